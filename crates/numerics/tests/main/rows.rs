//! Kernels on rows against nalgebra, for random matrices of every small size.

use bracketry_numerics::rows::{
    Strided, add_multiple, add_product, add_symmetric_product, add_symmetric_times, add_weighted_squares, dot,
    eliminate,
};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// A matrix, and its rows at a distance that leaves room after each.
fn matrix(rows: usize, columns: usize, seed: u64) -> (DMatrix<f64>, Vec<f64>, usize) {
    let mut state = seed;
    let m = DMatrix::from_fn(rows, columns, |_, _| {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        // A quarter are zero: whole groups of them are left out.
        if state.is_multiple_of(4) { 0.0 } else { (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0 }
    });
    let distance = columns + 2;
    let mut by_rows = vec![9.0; rows * distance];
    for i in 0..rows {
        (0..columns).for_each(|j| by_rows[i * distance + j] = m[(i, j)]);
    }
    (m, by_rows, distance)
}

fn assert_upper(found: &[f64], row: usize, expected: &DMatrix<f64>) {
    for i in 0..expected.nrows() {
        for j in i..expected.ncols() {
            assert!((found[i * row + j] - expected[(i, j)]).abs() < 1e-11, "{i} {j}");
        }
    }
}

proptest! {
    #[test]
    fn products_are_products(rows in 1usize..12, inner in 1usize..14, columns in 1usize..14, seed: u64) {
        let (c, mut c_rows, c_row) = matrix(rows, columns, seed);
        let (a, a_rows, a_row) = matrix(rows, inner, !seed);
        let (b, b_rows, b_row) = matrix(inner, columns, seed ^ 7);
        let first = columns / 3;
        add_product(&mut c_rows, c_row, Strided::new(&a_rows, a_row), (&b_rows, b_row), (rows, inner), first..columns);
        let expected = &c + &a * &b;
        for i in 0..rows {
            for j in 0..columns {
                let value = if j < first { c[(i, j)] } else { expected[(i, j)] };
                prop_assert!((c_rows[i * c_row + j] - value).abs() < 1e-12);
            }
        }
        let (at, at_rows, at_row) = matrix(inner, rows, seed ^ 3);
        let mut product = vec![0.0; rows * c_row];
        add_product(&mut product, c_row, Strided::new(&at_rows, at_row).transposed(), (&b_rows, b_row), (rows, inner), 0..columns);
        let expected = at.transpose() * &b;
        prop_assert!((0..rows).all(|i| (0..columns).all(|j| (product[i * c_row + j] - expected[(i, j)]).abs() < 1e-12)));
    }

    #[test]
    fn symmetric_products_and_squares_fill_the_upper_triangle(size in 1usize..14, inner in 1usize..14, seed: u64) {
        let (a, a_rows, row) = matrix(inner, size, seed);
        let s = DMatrix::from_fn(inner, inner, |i, j| 1.0 / (1 + i + j) as f64);
        let b = &s * &a;
        let mut b_rows = vec![0.0; inner * row];
        (0..inner).for_each(|i| (0..size).for_each(|j| b_rows[i * row + j] = b[(i, j)]));
        let mut c = vec![0.0; size * row];
        add_symmetric_product(&mut c, row, &a_rows, &b_rows, (size, inner));
        assert_upper(&c, row, &(a.transpose() * &b));
        let weights: Vec<f64> = (0..inner).map(|l| l as f64 - 1.5).collect();
        // The squares stand in the lower right corner of a larger matrix.
        let (whole, first) = (size + 2, 2);
        let mut c = vec![0.0; whole * whole];
        add_weighted_squares(&mut c, whole, first, (&a_rows, row), size, &weights);
        let expected = a.transpose() * DMatrix::from_diagonal(&DVector::from_vec(weights)) * &a;
        for i in 0..size {
            for j in i..size {
                prop_assert!((c[(first + i) * whole + first + j] - expected[(i, j)]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn elimination_leaves_the_factor_and_the_schur_complement(size in 1usize..15, pivots in 0usize..15, seed: u64) {
        let pivots = pivots.min(size);
        let (a, ..) = matrix(size + 3, size, seed);
        let m = a.transpose() * &a + DMatrix::identity(size, size) * 0.1;
        let row = size + 1;
        let mut rows = vec![0.0; size * row];
        (0..size).for_each(|i| (i..size).for_each(|j| rows[i * row + j] = m[(i, j)]));
        prop_assert!(eliminate(&mut rows, row, (pivots, size), 1e-14));
        let upper = DMatrix::from_fn(pivots, size, |i, j| if j >= i { rows[i * row + j] } else { 0.0 });
        let rest = &m - upper.transpose() * &upper;
        for i in 0..size {
            for j in i..size {
                let expected = if i < pivots { 0.0 } else { rows[i * row + j] };
                prop_assert!((rest[(i, j)] - expected).abs() < 1e-12 * (1.0 + m.norm()));
            }
        }
    }

    #[test]
    fn vectors_are_multiplied(size in 1usize..20, seed: u64) {
        let (m, ..) = matrix(size, size, seed);
        let m = &m + m.transpose();
        let x: Vec<f64> = (0..size).map(|i| 0.3 * i as f64 - 1.0).collect();
        let v = DVector::from_vec(x.clone());
        let row = size + 1;
        let mut upper = vec![7.0; size * row];
        (0..size).for_each(|i| (i..size).for_each(|j| upper[i * row + j] = m[(i, j)]));
        let mut y = vec![1.0; size];
        add_symmetric_times(&mut y, &upper, row, &x);
        let expected = &m * &v;
        prop_assert!((0..size).all(|i| (y[i] - 1.0 - expected[i]).abs() < 1e-12));
        prop_assert!((dot(&x, &y) - v.dot(&DVector::from_vec(y.clone()))).abs() < 1e-11);
        let before = y.clone();
        add_multiple(&mut y, -0.5, &x);
        prop_assert!((0..size).all(|i| (y[i] - (before[i] - 0.5 * x[i])).abs() < 1e-15));
    }
}

#[test]
fn a_matrix_that_is_not_positive_definite_is_noticed() {
    assert!(!eliminate(&mut [1.0, 2.0, 0.0, 1.0], 2, (2, 2), 1e-14));
    assert!(!eliminate(&mut [f64::NAN], 1, (1, 1), 1e-14));
    assert!(!eliminate(&mut [f64::INFINITY], 1, (1, 1), 1e-14));
    // Its first pivot alone is positive.
    assert!(eliminate(&mut [1.0, 2.0, 0.0, 1.0], 2, (1, 2), 1e-14));
}
