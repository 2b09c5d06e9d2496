//! Matrices of rational numbers.

use bracketry_symbolic::{Echelon, Rational, UnivariatePolynomial};

use crate::linear::characteristic::characteristic_polynomial;

/// A matrix by its rows, all of the same length.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct RationalMatrix {
    rows: Vec<Vec<Rational>>,
    columns: usize,
}

impl RationalMatrix {
    /// From its rows, of `columns` entries each.
    pub fn new(rows: Vec<Vec<Rational>>, columns: usize) -> Self {
        RationalMatrix { rows, columns }
    }

    /// Its rows.
    pub fn rows(&self) -> &[Vec<Rational>] {
        &self.rows
    }

    /// Rows and columns exchanged.
    pub fn transposed(&self) -> Self {
        let rows = (0..self.columns).map(|j| self.rows.iter().map(|r| r[j].clone()).collect()).collect();
        RationalMatrix { rows, columns: self.rows.len() }
    }

    /// The product with a column.
    pub fn times(&self, v: &[Rational]) -> Vec<Rational> {
        self.rows.iter().map(|row| dot(row, v)).collect()
    }

    /// A basis of {v : M v = 0}, one vector for each column without pivot, with 1 there.
    pub fn null_space(&self) -> Vec<Vec<Rational>> {
        Echelon::new(&self.rows, self.columns).null_space()
    }

    /// Whether a symmetric matrix is positive semidefinite, by symmetric elimination.
    pub fn is_positive_semidefinite(&self) -> bool {
        semidefinite(self.rows.clone())
    }

    /// M⁻¹ of a square matrix; `None` if it is singular.
    pub(crate) fn inverse(&self) -> Option<Self> {
        let n = self.rows.len();
        let mut echelon = Echelon::empty(2 * n);
        for (i, row) in self.rows.iter().enumerate() {
            let unit = (0..n).map(|j| if i == j { Rational::ONE } else { Rational::ZERO });
            echelon.insert(row.iter().cloned().chain(unit).collect());
        }
        let rows = echelon.rows.into_iter().map(|mut row| row.split_off(n)).collect();
        echelon.pivots.into_iter().eq(0..n).then_some(RationalMatrix { rows, columns: n })
    }

    /// det(λ − M) of a square matrix.
    pub fn characteristic_polynomial(&self) -> UnivariatePolynomial {
        characteristic_polynomial(&self.rows)
    }
}

fn dot(a: &[Rational], b: &[Rational]) -> Rational {
    a.iter().zip(b).filter(|(x, _)| **x != Rational::ZERO).fold(Rational::ZERO, |s, (x, y)| s + x * y)
}

/// Whether a symmetric matrix is positive semidefinite, by symmetric elimination.
pub(crate) fn semidefinite(mut q: Vec<Vec<Rational>>) -> bool {
    let n = q.len();
    for k in 0..n {
        if q[k][k] < Rational::ZERO {
            return false;
        }
        if q[k][k] == Rational::ZERO {
            if (k..n).any(|j| q[k][j] != Rational::ZERO) {
                return false;
            }
            continue;
        }
        for i in k + 1..n {
            let factor = &q[i][k] / &q[k][k];
            for j in k..n {
                let step = &factor * &q[k][j];
                q[i][j] -= step;
            }
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn matrix(n: usize, entries: &[i8]) -> RationalMatrix {
        let rows = entries.chunks(n).map(|r| r.iter().map(|&x| Rational::from(i64::from(x))).collect()).collect();
        RationalMatrix::new(rows, n)
    }

    proptest! {
        /// Cayley and Hamilton: a matrix is a root of its characteristic polynomial.
        #[test]
        fn a_matrix_satisfies_its_characteristic_polynomial(n in 1usize..7, entries in prop::collection::vec(-3i8..4, 49), v in prop::collection::vec(-3i8..4, 7)) {
            let a = matrix(n, &entries[..n * n]);
            let p = a.characteristic_polynomial();
            prop_assert_eq!(p.degree(), n);
            let v: Vec<Rational> = v[..n].iter().map(|&x| Rational::from(i64::from(x))).collect();
            let mut sum = vec![Rational::ZERO; n];
            for c in p.coefficients().iter().rev() {
                sum = a.times(&sum).into_iter().zip(&v).map(|(s, x)| s + c * x).collect();
            }
            prop_assert!(sum.iter().all(|x| *x == Rational::ZERO));
        }

        /// Rank and nullity add up to the number of columns, and the null space is mapped to zero.
        #[test]
        fn rank_and_nullity_add_up(m in 1usize..6, n in 1usize..6, entries in prop::collection::vec(-1i8..2, 36)) {
            let a = matrix(n, &entries[..m * n]);
            let echelon = Echelon::new(a.rows(), n);
            let null_space = a.null_space();
            prop_assert_eq!(echelon.rank() + null_space.len(), n);
            for v in null_space {
                prop_assert!(a.times(&v).iter().all(|x| *x == Rational::ZERO));
            }
        }
    }
}
