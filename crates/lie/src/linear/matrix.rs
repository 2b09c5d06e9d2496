//! Matrices of exact numbers.

use std::cmp::Ordering;

use bracketry_symbolic::{Echelon, FieldElement, OrderedField, Rational, Real, UnivariatePolynomial};

use crate::linear::characteristic::characteristic_polynomial;

/// A matrix by its rows, all of the same length.
#[derive(Clone, Debug, PartialEq)]
#[must_use]
pub struct Matrix<C> {
    rows: Vec<Vec<C>>,
    columns: usize,
}

/// A matrix of rational numbers.
pub type RationalMatrix = Matrix<Rational>;

impl<C: OrderedField> Matrix<C> {
    /// From its rows, of `columns` entries each.
    pub fn new(rows: Vec<Vec<C>>, columns: usize) -> Self {
        Matrix { rows, columns }
    }

    /// Its rows.
    pub fn rows(&self) -> &[Vec<C>] {
        &self.rows
    }

    /// Rows and columns exchanged.
    pub fn transposed(&self) -> Self {
        let rows = (0..self.columns).map(|j| self.rows.iter().map(|r| r[j].clone()).collect()).collect();
        Matrix { rows, columns: self.rows.len() }
    }

    /// The product with a column.
    pub fn times(&self, v: &[C]) -> Vec<C> {
        self.rows.iter().map(|row| dot(row, v)).collect()
    }

    /// A basis of {v : M v = 0}, one vector for each column without pivot, with 1 there.
    pub fn null_space(&self) -> Vec<Vec<C>> {
        Echelon::new(&self.rows, self.columns).null_space()
    }

    /// M⁻¹ of a square matrix; `None` if it is singular.
    pub(crate) fn inverse(&self) -> Option<Self> {
        let n = self.rows.len();
        let mut echelon = Echelon::empty(2 * n);
        for (i, row) in self.rows.iter().enumerate() {
            let unit = (0..n).map(|j| if i == j { C::ONE } else { C::ZERO });
            echelon.insert(row.iter().cloned().chain(unit).collect());
        }
        let rows = echelon.rows.into_iter().map(|mut row| row.split_off(n)).collect();
        echelon.pivots.into_iter().eq(0..n).then_some(Matrix { rows, columns: n })
    }
}

impl RationalMatrix {
    /// det(λ − M) of a square matrix.
    pub fn characteristic_polynomial(&self) -> UnivariatePolynomial {
        characteristic_polynomial(&self.rows)
    }

    /// Whether a symmetric matrix is positive semidefinite, by symmetric elimination.
    pub fn is_positive_semidefinite(&self) -> bool {
        semidefinite(self.rows.clone()) == Some(true)
    }
}

impl Matrix<Real> {
    /// The matrix, if all entries are seen to be rational.
    pub(crate) fn rational(&self) -> Option<RationalMatrix> {
        let row = |r: &Vec<Real>| r.iter().map(|x| x.rational().cloned()).collect::<Option<Vec<_>>>();
        Some(RationalMatrix::new(self.rows.iter().map(row).collect::<Option<_>>()?, self.columns))
    }

    /// det(λ − M) of a square matrix, by the traces of N_k = M N_(k−1) + c_(n−k+1) (Faddeev and LeVerrier), which divide by integers only.
    pub(crate) fn characteristic_polynomial(&self) -> UnivariatePolynomial<Real> {
        let n = self.rows.len();
        let columns = self.transposed();
        let mut c = vec![Real::ONE; n + 1];
        let mut product = vec![vec![Real::ZERO; n]; n];
        for k in 1..=n {
            for (i, row) in product.iter_mut().enumerate() {
                row[i] += &c[n - k + 1];
            }
            // N M = M N
            product = product.iter().map(|row| columns.times(row)).collect();
            let trace = (0..n).fold(Real::ZERO, |s, i| s + &product[i][i]);
            c[n - k] = trace / Real::from(-(k as i64));
        }
        UnivariatePolynomial::new(c)
    }
}

/// The matrix of A on the vectors modulo span{A^k b_i}, in the coordinates w_i x of an annihilating basis; `b` has
/// a row for each input.
pub(crate) fn quotient_by_reachable<C: OrderedField>(a: &Matrix<C>, b: &Matrix<C>) -> Matrix<C> {
    let reached = Echelon::invariant(b.rows(), a.rows().len(), |v| a.times(v));
    // W A = Q W, and W is the identity on the columns without pivot.
    let columns: Vec<usize> = reached.free_columns().collect();
    let transposed = a.transposed();
    let rows = reached.null_space().into_iter().map(|w| {
        let image = transposed.times(&w);
        columns.iter().map(|&j| image[j].clone()).collect()
    });
    Matrix::new(rows.collect(), columns.len())
}

fn dot<C: OrderedField>(a: &[C], b: &[C]) -> C {
    a.iter().zip(b).filter(|(x, _)| !x.is_zero()).fold(C::ZERO, |s, (x, y)| s.plus(&x.times(y)))
}

/// Whether a symmetric matrix is positive semidefinite, by symmetric elimination; `None` where a sign is not known.
pub(crate) fn semidefinite<C: OrderedField>(mut q: Vec<Vec<C>>) -> Option<bool> {
    let n = q.len();
    for k in 0..n {
        match q[k][k].sign()? {
            Ordering::Less => return Some(false),
            Ordering::Equal if (k..n).any(|j| !q[k][j].is_zero()) => return Some(false),
            Ordering::Equal => continue,
            Ordering::Greater => {}
        }
        let Some(inverse) = q[k][k].inverse() else { continue };
        for i in k + 1..n {
            let factor = q[i][k].times(&inverse);
            for j in k..n {
                let above = q[k][j].clone();
                q[i][j].subtract_product(&factor, &above);
            }
        }
    }
    Some(true)
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
