//! Lyapunov and Riccati equations of random systems, and a textbook gain.

use bracketry_numerics::matrix_equations::{lyapunov, riccati};
use nalgebra::DMatrix;

fn random(n: usize, m: usize, seed: u64) -> DMatrix<f64> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    DMatrix::from_fn(n, m, |_, _| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

#[test]
fn lyapunov_equations_are_solved() {
    for seed in 1..40 {
        let n = 1 + seed as usize % 9;
        let a = random(n, n, seed) - DMatrix::identity(n, n) * 2.0;
        let b = random(n, 2, seed + 1000);
        let q = &b * b.transpose();
        let Some(x) = lyapunov(&a, &q) else { unreachable!("{seed}") };
        assert!((&a * &x + &x * a.transpose() + &q).norm() <= 1e-13 * (1.0 + x.norm() * a.norm()), "{seed}");
    }
}

#[test]
fn riccati_equations_are_solved_and_stabilize() {
    for seed in 1..60 {
        let (n, m) = (1 + seed as usize % 10, 1 + seed as usize % 3);
        let (a, b) = (random(n, n, seed) * 2.0, random(n, m, seed + 1000));
        let found = riccati(&a, &b, &DMatrix::identity(n, n), &DMatrix::identity(m, m));
        assert!(found.as_ref().is_some_and(|f| f.residual < 1e-12), "{seed}: {found:?}");
    }
}

/// The double integrator with unit weights: K = [1, √3].
#[test]
fn the_double_integrator_has_its_textbook_gain() {
    let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 0.0, 0.0]);
    let b = DMatrix::from_row_slice(2, 1, &[0.0, 1.0]);
    let Some(found) = riccati(&a, &b, &DMatrix::identity(2, 2), &DMatrix::identity(1, 1)) else { unreachable!() };
    assert!((found.gain - DMatrix::from_row_slice(1, 2, &[1.0, 3f64.sqrt()])).norm() < 1e-14);
    // An unstable state that no input reaches.
    let a = DMatrix::from_diagonal_element(2, 2, 1.0);
    assert!(riccati(&a, &b, &DMatrix::identity(2, 2), &DMatrix::identity(1, 1)).is_none());
}
