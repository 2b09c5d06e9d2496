//! Eigenvalues of matrices on which iterations without a bound do not end.

use bracketry_numerics::eigen::{balance, eigenvalues, pseudo_inverse, smallest_singular_value, svd, symmetric_eigen};
use nalgebra::{Complex, DMatrix, DVector};
use proptest::prelude::*;

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
        assert!(svd(&a).is_none() && pseudo_inverse(&a, 1e-12).is_none());
        assert_eq!(smallest_singular_value(a.map(Complex::from)), None);
    }
}

#[test]
fn a_pseudo_inverse_fulfills_the_conditions_of_penrose() {
    for n in 1..8 {
        // Of rank one less than its size.
        let a = DMatrix::from_fn(n, n + 1, |i, j| if i + 1 == n { 0.0 } else { ((i * 5 + j * 3) % 7) as f64 - 2.5 });
        let inverse = pseudo_inverse(&a, 1e-12).unwrap();
        let size = a.norm() + inverse.norm();
        assert!((&a * &inverse * &a - &a).norm() <= 1e-12 * size);
        assert!((&inverse * &a * &inverse - &inverse).norm() <= 1e-12 * size);
        assert!((&a * &inverse - (&a * &inverse).transpose()).norm() <= 1e-12 * size);
    }
}

/// The real form [[Re, −Im], [Im, Re]] of a complex matrix has its singular values, each twice.
#[test]
fn the_smallest_singular_value_is_that_of_the_real_form() {
    for (rows, columns) in [(1, 1), (2, 3), (4, 2), (5, 5)] {
        let part = |shift: usize| DMatrix::from_fn(rows, columns, |i, j| ((i * 7 + j * 5 + shift) % 11) as f64 - 4.3);
        let (re, im) = (part(0), part(3));
        let real = DMatrix::from_fn(2 * rows, 2 * columns, |i, j| {
            let (block, at) = ((i / rows, j / columns), (i % rows, j % columns));
            match block {
                (0, 1) => -im[at],
                (1, 0) => im[at],
                _ => re[at],
            }
        });
        let expected = svd(&real).unwrap().singular_values.min();
        let found = smallest_singular_value(re.zip_map(&im, Complex::new)).unwrap();
        assert!((found - expected).abs() <= 1e-13 * real.norm(), "{found} {expected}");
    }
}

/// The factors are orthonormal, the singular values descend, and their product is the matrix.
fn assert_decomposed(a: &DMatrix<f64>) {
    let found = svd(a).unwrap();
    let (u, v_t, s) = (found.u.unwrap(), found.v_t.unwrap(), found.singular_values);
    let one = DMatrix::identity(s.len(), s.len());
    assert!((u.tr_mul(&u) - &one).amax() <= 1e-13 && (&v_t * v_t.transpose() - one).amax() <= 1e-13, "{a}");
    assert!(s.as_slice().windows(2).all(|w| w[0] >= w[1]) && s.min() >= 0.0);
    assert!((u * DMatrix::from_diagonal(&s) * v_t - a).amax() <= 1e-13 * a.amax(), "{a}");
}

proptest! {
    /// Matrices of every rank, with rows and columns of very different size.
    #[test]
    fn a_matrix_is_the_product_of_its_factors(
        (rows, columns, rank) in (1..8usize, 1..8usize, 0..8usize),
        entries in prop::collection::vec(-3..4i32, 112),
        sizes in prop::collection::vec(-40..40i32, 16),
    ) {
        let left = DMatrix::from_fn(rows, rank, |i, j| f64::from(entries[i * 7 + j]));
        let right = DMatrix::from_fn(rank, columns, |i, j| f64::from(entries[56 + i * 8 + j]));
        let plain = left * right;
        assert_decomposed(&plain);
        assert_decomposed(&DMatrix::from_fn(rows, columns, |i, j| plain[(i, j)] * 2f64.powi(sizes[i] + sizes[8 + j])));
        assert_decomposed(&(&plain * 1e-290));
        assert_decomposed(&(plain * 1e290));
    }

    /// Q₁ D Q₂ with random reflections Q has the singular values D.
    #[test]
    fn singular_values_are_those_of_the_construction(
        values in prop::collection::vec(-14.0..1.0f64, 5),
        directions in prop::collection::vec(0.1..1.0f64, 12),
    ) {
        let reflection = |d: &[f64]| {
            let d = DVector::from_column_slice(d).normalize();
            DMatrix::identity(d.len(), d.len()) - &d * d.transpose() * 2.0
        };
        let mut diagonal = DMatrix::zeros(7, 5);
        let mut sorted: Vec<f64> = values.iter().map(|v| 10f64.powf(*v)).collect();
        (0..5).for_each(|i| diagonal[(i, i)] = sorted[i]);
        let a = reflection(&directions[..7]) * diagonal * reflection(&directions[7..]);
        sorted.sort_by(|x, y| y.total_cmp(x));
        let found = svd(&a).unwrap().singular_values;
        prop_assert!(found.iter().zip(&sorted).all(|(f, s)| (f - s).abs() <= 1e-13 * sorted[0]), "{found} {sorted:?}");
    }
}

/// Sizes at which the QR algorithm of nalgebra takes √(rows · columns) for other numbers, and a matrix of full rank.
#[test]
fn matrices_of_ones_are_decomposed() {
    for rows in 1..30 {
        for columns in 1..30 {
            let ones = DMatrix::from_element(rows, columns, 1.0);
            assert_decomposed(&ones);
            let exact = ((rows * columns) as f64).sqrt();
            assert!((svd(&ones).unwrap().singular_values[0] - exact).abs() <= 1e-13 * exact);
        }
    }
    assert_decomposed(&DMatrix::from_row_slice(3, 3, &[1.0, 2.0, 2.0, 2.0, -1.0, -1.0, 2.0, 1.0, -1.0]));
    assert_decomposed(&DMatrix::zeros(4, 3));
    assert!(svd(&DMatrix::zeros(0, 3)).is_none());
}

/// Entries whose squares overflow, or vanish, end too.
#[test]
fn entries_of_any_size_end() {
    for size in [1e-320, 1e-200, 1e149, 1e151, 1e200, 1e308] {
        for other in [0.0, 1e-300, 1.0, 1e300] {
            let a = DMatrix::from_row_slice(2, 2, &[1.0, size, other, -1.0]);
            let units = balance(&mut a.clone());
            assert!(units.iter().all(|u| *u > 0.0 && u.is_finite()), "{size} {other}: {units}");
            // Found or not: it ends.
            let _ = eigenvalues(&a);
        }
    }
}

proptest! {
    /// Units of the states do not change the eigenvalues: those of a triangular matrix stay its diagonal in units that differ by many orders
    /// of magnitude.
    #[test]
    fn eigenvalues_do_not_depend_on_units(
        (diagonal, above, powers) in (2usize..7).prop_flat_map(|n| (
            prop::collection::vec(-20i32..20, n),
            prop::collection::vec(-10i32..10, n * n),
            prop::collection::vec(-8i32..9, n),
        )),
    ) {
        let n = diagonal.len();
        // Well separated, so that they are well conditioned.
        let own = |i: usize| f64::from(diagonal[i]) + 50.0 * i as f64;
        let unit = |i: usize| 10f64.powi(powers[i]);
        let a = DMatrix::from_fn(n, n, |i, j| {
            let entry = match i.cmp(&j) {
                std::cmp::Ordering::Equal => own(i),
                std::cmp::Ordering::Less => f64::from(above[i * n + j]),
                std::cmp::Ordering::Greater => 0.0,
            };
            entry * unit(i) / unit(j)
        });
        let mut values = eigenvalues(&a).unwrap();
        values.sort_by(|x, y| x.0.total_cmp(&y.0));
        let mut expected: Vec<f64> = (0..n).map(own).collect();
        expected.sort_by(f64::total_cmp);
        for (found, exact) in values.iter().zip(&expected) {
            prop_assert!((found.0 - exact).abs() < 1e-8 && found.1.abs() < 1e-8, "{values:?} for {expected:?}");
        }
    }
}
