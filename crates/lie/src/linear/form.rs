//! Quadratic forms.

use bracketry_symbolic::Rational;

use crate::linear::matrix::RationalMatrix;

/// Whether the quadratic form of a symmetric matrix takes positive, and whether it takes negative values (Lagrange's
/// reduction to squares).
pub(crate) fn signs(q: &RationalMatrix) -> (bool, bool) {
    let mut q = q.rows().to_vec();
    let (mut positive, mut negative) = (false, false);
    while let Some(n) = q.len().checked_sub(1) {
        let Some(p) = (0..=n).find(|&i| q[i][i] != Rational::ZERO) else {
            // 2 q_ij x_i x_j alone.
            let mixed = q.iter().flatten().any(|e| *e != Rational::ZERO);
            return (positive || mixed, negative || mixed);
        };
        if q[p][p] > Rational::ZERO {
            positive = true;
        } else {
            negative = true;
        }
        q.swap(p, n);
        for row in &mut q {
            row.swap(p, n);
        }
        let Some(last) = q.pop() else { break };
        for row in &mut q {
            let factor = row[n].clone() / &last[n];
            for (e, l) in row.iter_mut().zip(&last) {
                *e -= &factor * l;
            }
            row.truncate(n);
        }
    }
    (positive, negative)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Tᵀ D T takes the signs of D.
        #[test]
        fn signs_are_those_of_the_squares(
            d in prop::collection::vec(-1i8..2, 1..5),
            t in prop::collection::vec(-3i8..4, 16),
        ) {
            let n = d.len();
            // Unimodular: 1 on the diagonal, 0 below; then mixed by its transpose.
            let entry = |i: usize, j: usize, kept: bool| if i == j { 1 } else { i8::from(kept) * t[4 * i + j] };
            let upper = |i: usize, j: usize| entry(i, j, i < j);
            let lower = |i: usize, j: usize| entry(i, j, i > j);
            let mix = |i: usize, j: usize| (0..n).map(|k| i64::from(upper(i, k)) * i64::from(lower(k, j))).sum::<i64>();
            let of_form = |i: usize, j: usize| -> Rational {
                Rational::from((0..n).map(|k| mix(k, i) * i64::from(d[k]) * mix(k, j)).sum::<i64>())
            };
            let q = RationalMatrix::new((0..n).map(|i| (0..n).map(|j| of_form(i, j)).collect()).collect(), n);
            prop_assert_eq!(signs(&q), (d.contains(&1), d.contains(&-1)));
        }
    }
}
