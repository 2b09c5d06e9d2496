//! Eigenvalues of matrices on which iterations without a bound do not end.

use bracketry_numerics::eigen::{eigenvalues, pseudo_inverse, svd, symmetric_eigen};
use nalgebra::DMatrix;

/// x0' = u, x_i' = x0 − x_i, on which the QR algorithm without a limit does not end.
#[test]
fn stars_and_complete_graphs_end() {
    for n in 2..30usize {
        let star = DMatrix::from_fn(n, n, |i, j| match (i, j) {
            (0, _) => 0.0,
            (i, j) if i == j => -1.0,
            (_, 0) => 1.0,
            _ => 0.0,
        });
        let complete = DMatrix::from_fn(n, n, |i, j| if i == j { 1.0 - n as f64 } else { 1.0 });
        for a in [star, complete] {
            if let Some(found) = eigenvalues(&a) {
                let trace: f64 = found.iter().map(|z| z.0).sum();
                assert!((trace - a.trace()).abs() <= 1e-9 * a.norm(), "{n}: {found:?}");
            }
        }
    }
}

#[test]
fn what_is_not_a_number_has_no_eigenvalues() {
    for bad in [f64::NAN, f64::INFINITY] {
        let a = DMatrix::from_row_slice(2, 2, &[1.0, bad, 0.0, 1.0]);
        assert!(eigenvalues(&a).is_none() && symmetric_eigen(a.clone()).is_none());
        assert!(svd(a.clone()).is_none() && pseudo_inverse(a, 1e-12).is_none());
    }
}

#[test]
fn a_pseudo_inverse_fulfills_the_conditions_of_penrose() {
    for n in 1..8 {
        // Of rank one less than its size.
        let a = DMatrix::from_fn(n, n + 1, |i, j| if i + 1 == n { 0.0 } else { ((i * 5 + j * 3) % 7) as f64 - 2.5 });
        let inverse = pseudo_inverse(a.clone(), 1e-12).unwrap();
        let size = a.norm() + inverse.norm();
        assert!((&a * &inverse * &a - &a).norm() <= 1e-12 * size);
        assert!((&inverse * &a * &inverse - &inverse).norm() <= 1e-12 * size);
        assert!((&a * &inverse - (&a * &inverse).transpose()).norm() <= 1e-12 * size);
    }
}
