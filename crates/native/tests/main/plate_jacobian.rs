//! The Jacobian that the benchmark times is the same by all three means.

#[path = "../../benches/model/mod.rs"]
mod model;

use approx::assert_relative_eq;
use bracketry_native::{Backend, Function, Workspace};

#[test]
fn machine_code_agrees_with_a_jacobian_written_by_hand() {
    let f = Function::new(model::tape());
    assert_eq!(f.backend(), Backend::Native);
    for point in [
        [0.02, 0.7, 0.13, -0.05, 0.4, 0.1, 3.0, -0.8, 2.0],
        [-0.1, -2.0, -0.3, 0.2, -5.0, -0.3, -40.0, 2.5, -1.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    ] {
        let mut expected = [0.0; model::ROWS * model::COLUMNS];
        let mut got = expected;
        model::by_hand(&point, &mut expected);
        f.call(&point, &mut Workspace::default(), &mut got);
        for (e, g) in expected.iter().zip(&got) {
            assert_relative_eq!(e, g, max_relative = 1e-11, epsilon = 1e-11);
        }
    }
}

#[test]
fn copies_of_the_jacobian_agree_with_the_tape_across_chunks() {
    let tape = model::repeated(20);
    let (native, plain) = (
        Function::with_backend(tape.clone(), Backend::Native).unwrap(),
        Function::with_backend(tape, Backend::Tape).unwrap(),
    );
    let point = [0.02, 0.7, 0.13, -0.05, 0.4, 0.1, 3.0, -0.8, 2.0];
    let (mut a, mut b) = (vec![0.0; native.n_outputs()], vec![0.0; plain.n_outputs()]);
    native.call(&point, &mut Workspace::default(), &mut a);
    plain.call(&point, &mut Workspace::default(), &mut b);
    assert_eq!(a, b);
}
