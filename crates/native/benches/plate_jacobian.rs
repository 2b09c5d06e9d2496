//! A 6 × 7 Jacobian by the tape, by machine code and by hand, and what compiling costs.

mod model;

use bracketry_native::{Backend, Function, Workspace};
use divan::{Bencher, black_box};

const POINT: [f64; 9] = [0.02, 0.7, 0.13, -0.05, 0.4, 0.1, 3.0, -0.8, 2.0];

fn main() {
    divan::main();
}

fn evaluate(bencher: Bencher, backend: Backend) {
    let f = Function::with_backend(model::tape(), backend).expect("a supported host");
    let (mut work, mut out) = (Workspace::default(), [0.0; model::ROWS * model::COLUMNS]);
    bencher.bench_local(|| {
        f.call(black_box(&POINT), &mut work, &mut out);
        black_box(&out);
    });
}

#[divan::bench(sample_size = 1000)]
fn tape(bencher: Bencher) {
    evaluate(bencher, Backend::Tape);
}

#[divan::bench(sample_size = 1000)]
fn native(bencher: Bencher) {
    evaluate(bencher, Backend::Native);
}

#[divan::bench(sample_size = 1000)]
fn by_hand(bencher: Bencher) {
    let mut out = [0.0; model::ROWS * model::COLUMNS];
    bencher.bench_local(|| {
        model::by_hand(black_box(&POINT), &mut out);
        black_box(&out);
    });
}

/// Evaluation of long tapes.
#[divan::bench(args = [4, 16, 64], consts = [false, true], sample_size = 10)]
fn long<const NATIVE: bool>(bencher: Bencher, copies: usize) {
    let backend = if NATIVE { Backend::Native } else { Backend::Tape };
    let f = Function::with_backend(model::repeated(copies), backend).expect("a supported host");
    let (mut work, mut out) = (Workspace::default(), vec![0.0; f.n_outputs()]);
    bencher.counter(divan::counter::ItemsCount::new(f.tape().code().len())).bench_local(|| {
        f.call(black_box(&POINT), &mut work, &mut out);
        black_box(&out);
    });
}

/// Compile time by the number of copies of the Jacobian, at shifted arguments.
#[divan::bench(args = [1, 4, 16, 64], max_time = 3)]
fn compile(bencher: Bencher, copies: usize) {
    let tape = model::repeated(copies);
    bencher
        .counter(divan::counter::ItemsCount::new(tape.code().len()))
        .bench_local(|| Function::with_backend(tape.clone(), Backend::Native).expect("a supported host"));
}
