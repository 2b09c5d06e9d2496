//! Quadratic forms.

use std::cmp::Ordering;

use bracketry_symbolic::OrderedField;

use crate::linear::matrix::Matrix;

/// Whether the quadratic form of a symmetric matrix takes positive, and whether it takes negative values (Lagrange's
/// reduction to squares); `None` where a sign is not known.
pub(crate) fn signs<C: OrderedField>(q: &Matrix<C>) -> Option<(bool, bool)> {
    let mut q = q.rows().to_vec();
    let (mut positive, mut negative) = (false, false);
    while let Some(n) = q.len().checked_sub(1) {
        let Some(p) = (0..=n).find(|&i| !q[i][i].is_zero()) else {
            // 2 q_ij x_i x_j alone.
            let mixed = q.iter().flatten().any(|e| !e.is_zero());
            return Some((positive || mixed, negative || mixed));
        };
        match q[p][p].sign()? {
            Ordering::Greater => positive = true,
            _ => negative = true,
        }
        q.swap(p, n);
        for row in &mut q {
            row.swap(p, n);
        }
        let Some(last) = q.pop() else { break };
        let inverse = last[n].inverse()?;
        for row in &mut q {
            let factor = row[n].times(&inverse);
            for (e, l) in row.iter_mut().zip(&last) {
                e.subtract_product(&factor, l);
            }
            row.truncate(n);
        }
    }
    Some((positive, negative))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::matrix::RationalMatrix;
    use bracketry_symbolic::Rational;
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
            prop_assert_eq!(signs(&q), Some((d.contains(&1), d.contains(&-1))));
        }
    }
}
