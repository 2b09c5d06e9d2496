//! Compiled code gives its memory back. Alone in its process, because it watches the memory of the whole process.
#![allow(clippy::unwrap_used)]
#![cfg(target_os = "linux")]

use bracketry_native::{Backend, Function};
use bracketry_symbolic::{Pool, Tape};

/// Pages of this process that are resident, and mappings that it holds.
fn memory() -> (u64, usize) {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    let maps = std::fs::read_to_string("/proc/self/maps").unwrap();
    (pages.split_whitespace().nth(1).unwrap().parse().unwrap(), maps.lines().count())
}

#[test]
fn dropping_a_function_returns_its_memory() {
    let mut p = Pool::new();
    let e = p.parse("sin(x)*(x + 1)^5/(x^2 + 3) - tanh(x - 2)*sqrt(abs(x) + 0.1)").unwrap();
    let x = p.symbol("x");
    let d = p.diff(e, x);
    let tape = Tape::compile(&p, &[x], &[e, d]).unwrap();
    let compile = || drop(Function::with_backend(tape.clone(), Backend::Native).unwrap());
    (0..50).for_each(|_| compile());
    let before = memory();
    (0..1000).for_each(|_| compile());
    let after = memory();
    // A leak of one page per function would be 1000 pages, and of one mapping as many lines.
    assert!(after.0 < before.0 + 500, "resident pages {} → {}", before.0, after.0);
    assert!(after.1 < before.1 + 100, "mappings {} → {}", before.1, after.1);
}
