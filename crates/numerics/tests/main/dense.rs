//! Small dense matrices against their definitions and against nalgebra.

use approx::assert_relative_eq;
use bracketry_numerics::dense::{Lu, clip_to_psd, components};
use nalgebra::{DMatrix, SymmetricEigen};

#[test]
fn both_systems_are_solved() {
    let a = [0.0, 2.0, 1.0, 1.0, -1.0, 3.0, 4.0, 0.5, -2.0];
    let x = [1.0, -2.0, 0.5];
    let mut f = Lu::default();
    f.matrix(3).copy_from_slice(&a);
    assert!(f.factorize());
    let mut b: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[i * 3 + j] * x[j]).sum()).collect();
    let mut bt: Vec<f64> = (0..3).map(|i| (0..3).map(|j| a[j * 3 + i] * x[j]).sum()).collect();
    f.solve(&mut b, 1);
    f.solve_transposed(&mut bt);
    for i in 0..3 {
        assert_relative_eq!(b[i], x[i], epsilon = 1e-14);
        assert_relative_eq!(bt[i], x[i], epsilon = 1e-14);
    }
}

#[test]
fn a_singular_matrix_is_noticed() {
    let mut f = Lu::default();
    f.matrix(2).copy_from_slice(&[1.0, 2.0, 2.0, 4.0]);
    assert!(!f.factorize());
}

#[test]
fn a_semidefinite_matrix_is_left_alone() {
    for h in [[2.0, 1.0, 1.0, 3.0], [1.0, 1.0, 1.0, 1.0], [0.0; 4]] {
        let mut c = h;
        clip_to_psd(&mut c, 2, &mut Vec::new());
        assert_eq!(c, h);
    }
}

#[test]
fn the_negative_part_of_a_saddle_is_removed() {
    // xy has the eigenvalues ±1/2·2 with eigenvectors (1, ±1)/√2; the positive part is (x + y)²/4.
    let mut h = [0.0, 1.0, 1.0, 0.0];
    clip_to_psd(&mut h, 2, &mut Vec::new());
    for v in h {
        assert_relative_eq!(v, 0.5, epsilon = 1e-14);
    }
}

#[test]
fn the_positive_part_is_that_of_the_eigenvalue_decomposition() {
    for seed in 1..40 {
        let n = 2 + seed % 7;
        let m = DMatrix::from_fn(n, n, |i, j| {
            let (low, high) = (i.min(j) as f64, i.max(j) as f64);
            10f64.powi(seed as i32 % 5 - 2) * (seed as f64 * (1.3 + low) + 2.7 * high).sin()
        });
        let mut h = m.as_slice().to_vec();
        clip_to_psd(&mut h, n, &mut Vec::new());
        let mut eigen = SymmetricEigen::new(m.clone());
        eigen.eigenvalues.iter_mut().for_each(|l| *l = l.max(0.0));
        let expected = eigen.recompose();
        assert_relative_eq!(DMatrix::from_column_slice(n, n, &h), expected, epsilon = 1e-12 * m.norm());
    }
}

#[test]
fn chains_are_one_component() {
    let c = components(6, &[(4, 1), (1, 0), (3, 5)]);
    assert_eq!(c, vec![vec![0, 1, 4], vec![2], vec![3, 5]]);
}
