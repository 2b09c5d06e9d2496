//! Text to an expression, to text, and back: the same expression. What it compiles to by two means is the same number.

#![no_main]

use bracketry_native::{Backend, Function, Workspace};
use bracketry_symbolic::{Bindings, Language, Pool, Tape};
use libfuzzer_sys::fuzz_target;

/// Larger expressions are parsed and printed only.
const SMALL: f64 = 300.0;

fuzz_target!(|text: &str| {
    let mut pool = Pool::new();
    let Ok(e) = pool.parse(text) else { return };
    if !pool.is_printable(e) {
        return;
    }
    let printed = pool.text(e);
    let again = pool.parse(&printed).expect("printed text is an expression");
    if again != e {
        let difference = pool.sub(again, e);
        let verdict = pool.zero_test(difference, &Bindings::new());
        assert!(!verdict.is_nonzero(), "`{text}` prints as `{printed}`, which is something else");
    }
    let _ = pool.latex(e);
    if pool.tree_size(e) > SMALL {
        return;
    }
    let symbols = pool.symbols_of(&[e]);
    for language in [Language::Rust, Language::C, Language::Python] {
        let _ = pool.source(language, "f", &symbols, &[e]);
    }
    let mut roots = vec![e];
    for &s in &symbols {
        roots.push(pool.diff(e, s));
    }
    if pool.reachable(&roots).len() > 2000 {
        return;
    }
    let tape = Tape::compile(&pool, &symbols, &roots).expect("all symbols are arguments");
    let x: Vec<f64> = (0..symbols.len()).map(|i| 0.7 + 0.31 * i as f64).collect();
    let mut values = [vec![0.0; roots.len()], vec![0.0; roots.len()]];
    for (backend, out) in [Backend::Tape, Backend::Native].into_iter().zip(&mut values) {
        let f = Function::with_backend(tape.clone(), backend).expect("a small tape compiles");
        f.call(&x, &mut Workspace::default(), out);
    }
    for (a, b) in values[0].iter().zip(&values[1]) {
        assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "tape {a:?}, machine code {b:?}");
    }
});
