//! Choice of the evaluator, sharing between threads, and ownership of the code.

use bracketry_native::{Backend, Function, Workspace};
use bracketry_symbolic::{Pool, Tape};

/// A chain of `n` additions and multiplications.
fn chain(n: usize) -> Tape {
    let mut p = Pool::new();
    let x = p.symbol("x");
    let y = p.symbol("y");
    let (xs, ys) = (p.sym(x), p.sym(y));
    let mut e = xs;
    for i in 0..n {
        e = if i % 2 == 0 { p.add(e, ys) } else { p.mul(e, xs) };
    }
    Tape::compile(&p, &[x, y], &[e]).unwrap()
}

#[test]
fn the_length_of_the_tape_decides_on_the_backend() {
    assert_eq!(Function::new(chain(3)).backend(), Backend::Tape);
    assert_eq!(Function::new(chain(50)).backend(), Backend::Native);
    assert_eq!(Function::new(chain(20_001)).backend(), Backend::Tape);
    assert_eq!(Function::with_backend(chain(50), Backend::Tape).unwrap().backend(), Backend::Tape);
    assert_eq!(Function::with_backend(chain(3), Backend::Native).unwrap().backend(), Backend::Native);
}

#[test]
fn clones_work_in_other_threads_after_the_original_is_gone() {
    let f = Function::new(chain(50));
    assert_eq!((f.n_inputs(), f.n_outputs(), f.tape().code().len()), (2, 1, 50));
    let mut expected = [0.0];
    f.call(&[0.9, 1.1], &mut Workspace::default(), &mut expected);
    let threads: Vec<_> = (0..4)
        .map(|_| {
            let f = f.clone();
            std::thread::spawn(move || {
                let (mut work, mut out) = (Workspace::default(), [0.0]);
                for _ in 0..1000 {
                    f.call(&[0.9, 1.1], &mut work, &mut out);
                }
                out[0]
            })
        })
        .collect();
    drop(f);
    for t in threads {
        assert_eq!(t.join().unwrap(), expected[0]);
    }
}

#[test]
fn one_workspace_serves_functions_of_every_size() {
    let mut work = Workspace::default();
    for n in [10, 3000, 5, 200] {
        for backend in [Backend::Native, Backend::Tape] {
            let f = Function::with_backend(chain(n), backend).unwrap();
            let mut out = [0.0];
            f.call(&[0.5, 1.0], &mut work, &mut out);
            // The map e ↦ (e + 1)/2 has the fixed point 1.
            let expected =
                if n % 2 == 0 { 1.0 - 0.5f64.powi(n as i32 / 2 + 1) } else { 2.0 - 0.5f64.powi(n as i32 / 2 + 1) };
            assert_eq!(out[0], expected);
        }
    }
}

#[test]
#[should_panic(expected = "number of arguments")]
fn too_few_arguments_are_refused_by_machine_code() {
    Function::with_backend(chain(10), Backend::Native).unwrap().call(&[1.0], &mut Workspace::default(), &mut [0.0]);
}

#[test]
#[should_panic(expected = "number of results")]
fn too_few_results_are_refused_by_machine_code() {
    Function::with_backend(chain(10), Backend::Native).unwrap().call(&[1.0, 2.0], &mut Workspace::default(), &mut []);
}
