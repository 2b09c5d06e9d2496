//! Linear equations and the exponential function of matrices.

use bracketry_numerics::linear_equations::{exponential, nearly_null_vector, solve, solve_vector};
use nalgebra::{Complex, DMatrix, DVector};
use proptest::prelude::*;

fn matrix(n: usize, entries: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(n, n, |i, j| entries[i * n + j])
}

proptest! {
    #[test]
    fn a_solution_fulfills_the_equations(n in 1usize..7, entries in prop::collection::vec(-1.0..1.0f64, 36)) {
        // Diagonally dominant, so that it is regular.
        let a = matrix(n, &entries) + DMatrix::identity(n, n) * 8.0;
        let b = DMatrix::from_fn(n, 3, |i, j| entries[i + 7 * j]);
        let x = solve(a.clone(), &b).unwrap();
        prop_assert!((&a * &x - &b).amax() <= 1e-14);
        let first = solve_vector(a, &b.column(0).into_owned()).unwrap();
        prop_assert_eq!(first, x.column(0).into_owned());
    }

    #[test]
    fn exponentials_of_sums_of_one_matrix_are_products(
        n in 1usize..6, entries in prop::collection::vec(-2.0..2.0f64, 25), s in -1.5..1.5f64, t in -1.5..1.5f64,
    ) {
        let a = matrix(n, &entries);
        let both = exponential(&(&a * (s + t)));
        let product = exponential(&(&a * s)) * exponential(&(&a * t));
        let size = exponential(&(&a * s)).norm() * exponential(&(&a * t)).norm();
        prop_assert!((both - product).amax() <= 1e-12 * size);
    }
}

#[test]
fn singular_equations_have_no_solution() {
    for n in 1..5 {
        let a = DMatrix::from_fn(n, n, |_, j| j as f64);
        assert_eq!(solve(a.clone(), &DMatrix::identity(n, n)), None);
        assert_eq!(solve_vector(a, &DVector::from_element(n, 1.0)), None);
    }
}

/// Beside an eigenvalue it is the eigenvector: of a companion matrix the powers of the eigenvalue.
#[test]
fn inverse_iteration_finds_eigenvectors() {
    // (λ − 1)(λ² + 2λ + 5)
    let a = DMatrix::from_row_slice(3, 3, &[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 5.0, -3.0, -1.0]);
    for eigenvalue in [Complex::new(1.0, 0.0), Complex::new(-1.0, 2.0)] {
        let beside = eigenvalue + Complex::new(1e-9, 0.0);
        let shifted =
            DMatrix::from_fn(3, 3, |i, j| Complex::from(a[(i, j)]) - if i == j { beside } else { Complex::from(0.0) });
        let v = nearly_null_vector(shifted).unwrap();
        assert!((v.norm() - 1.0).abs() < 1e-14);
        assert!((v[1] / v[0] - eigenvalue).norm() < 1e-7 && (v[2] / v[1] - eigenvalue).norm() < 1e-7, "{v}");
    }
    assert_eq!(nearly_null_vector(DMatrix::from_element(2, 2, Complex::from(1.0))), None);
}
