//! Invariant zeros of x' = A x + B u, y = C x + D u, also with other numbers of inputs than of outputs.

use nalgebra::DMatrix;

use bracketry_numerics::eigen::{balance, eigenvalues, svd};
use bracketry_numerics::linear_equations::solve;

/// The matrices of a linear system.
#[derive(Clone, Debug)]
pub(crate) struct Quadruple {
    pub(crate) a: DMatrix<f64>,
    pub(crate) b: DMatrix<f64>,
    pub(crate) c: DMatrix<f64>,
    pub(crate) d: DMatrix<f64>,
}

/// An orthogonal matrix whose first columns span the range of `m`, and the rank.
fn range_first(m: &DMatrix<f64>, tolerance: f64) -> Option<(DMatrix<f64>, usize)> {
    let rows = m.nrows();
    if m.is_empty() {
        return Some((DMatrix::identity(rows, rows), 0));
    }
    // Square, so that the decomposition gives all of the basis.
    let mut square = DMatrix::zeros(rows, rows.max(m.ncols()));
    square.view_mut((0, 0), m.shape()).copy_from(m);
    let svd = svd(&square)?;
    let rank = svd.rank(tolerance);
    Some((svd.u?, rank))
}

fn stacked(upper: &DMatrix<f64>, lower: &DMatrix<f64>) -> DMatrix<f64> {
    let mut m = DMatrix::zeros(upper.nrows() + lower.nrows(), upper.ncols());
    m.rows_mut(0, upper.nrows()).copy_from(upper);
    m.rows_mut(upper.nrows(), lower.nrows()).copy_from(lower);
    m
}

impl Quadruple {
    fn dual(self) -> Self {
        Quadruple { a: self.a.transpose(), b: self.c.transpose(), c: self.b.transpose(), d: self.d.transpose() }
    }

    /// A system with the same finite zeros whose D has full row rank.
    fn with_full_row_rank(mut self, tolerance: f64) -> Option<Self> {
        for _ in 0..=self.a.nrows() {
            let (u, rank) = range_first(&self.d, tolerance)?;
            let (c, d) = (u.transpose() * &self.c, u.transpose() * &self.d);
            let tau = c.nrows() - rank;
            (self.c, self.d) = (c.rows(0, rank).into_owned(), d.rows(0, rank).into_owned());
            if tau == 0 {
                break;
            }
            // Outputs without inputs hold part of the state at zero.
            let held = c.rows(rank, tau).transpose();
            let (v, r) = range_first(&held, tolerance)?;
            if r == 0 {
                break;
            }
            let n = self.a.nrows() - r;
            let a = v.transpose() * &self.a * &v;
            let b = v.transpose() * &self.b;
            let c = &self.c * &v;
            let (free, gone) = ((r, n), (0, r));
            self = Quadruple {
                a: a.view((free.0, free.0), (n, n)).into_owned(),
                b: b.rows(free.0, n).into_owned(),
                c: stacked(&c.columns(free.0, n).into_owned(), &a.view((gone.0, free.0), (r, n)).into_owned()),
                d: stacked(&self.d, &b.rows(gone.0, r).into_owned()),
            };
        }
        Some(self)
    }

    /// The finite λ at which [A − λ, B; C, D] loses rank, by the reduction of Emami-Naeini and Van Dooren (1982), which orthogonal
    /// matrices alone make. `None` where a decomposition does not converge.
    pub(crate) fn zeros(self) -> Option<Vec<(f64, f64)>> {
        self.balanced().zeros_as_scaled()
    }

    /// The same system with its states in units in which large entries of A do not stand beside small ones (Parlett and Reinsch 1969).
    fn balanced(mut self) -> Self {
        let units = balance(&mut self.a);
        self.b.row_iter_mut().zip(units.iter()).for_each(|(mut row, unit)| row.unscale_mut(*unit));
        self.c.column_iter_mut().zip(units.iter()).for_each(|(mut column, unit)| column.scale_mut(*unit));
        self
    }

    fn zeros_as_scaled(self) -> Option<Vec<(f64, f64)>> {
        let size = [&self.a, &self.b, &self.c, &self.d].iter().map(|m| m.norm_squared()).sum::<f64>().sqrt();
        let tolerance = 10.0 * f64::EPSILON * size * (self.a.nrows() + self.b.ncols() + self.c.nrows()) as f64;
        let reduced = self.with_full_row_rank(tolerance)?.dual().with_full_row_rank(tolerance)?;
        if reduced.a.is_empty() {
            return Some(Vec::new());
        }
        let a = if reduced.d.is_empty() { reduced.a } else { reduced.a - reduced.b * solve(reduced.d, &reduced.c)? };
        eigenvalues(&a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: usize, columns: usize, entries: &[f64]) -> DMatrix<f64> {
        DMatrix::from_row_slice(rows, columns, entries)
    }

    /// (s + 2)(s − 3)/(s³ + …) in controllable canonical form, alone and with a second output or input.
    #[test]
    fn zeros_are_those_of_the_numerators() {
        let a = matrix(3, 3, &[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -1.0, -2.0, -3.0]);
        let b = matrix(3, 1, &[0.0, 0.0, 1.0]);
        let c = matrix(1, 3, &[-6.0, -1.0, 1.0]);
        let d = matrix(1, 1, &[0.0]);
        let one = Quadruple { a: a.clone(), b: b.clone(), c: c.clone(), d };
        let Some(mut zeros) = one.zeros() else { unreachable!() };
        zeros.sort_by(|x, y| x.0.total_cmp(&y.0));
        assert_eq!(zeros.len(), 2);
        assert!((zeros[0].0 + 2.0).abs() < 1e-12 && (zeros[1].0 - 3.0).abs() < 1e-12, "{zeros:?}");
        // The second output vanishes at s = −2 too, but not at 3: (s + 2)(s − 3) and (s + 2).
        let both = stacked(&c, &matrix(1, 3, &[2.0, 1.0, 0.0]));
        let two = Quadruple { a: a.clone(), b, c: both.clone(), d: matrix(2, 1, &[0.0, 0.0]) };
        let Some(zeros) = two.clone().zeros() else { unreachable!() };
        assert!(zeros.len() == 1 && (zeros[0].0 + 2.0).abs() < 1e-12, "{zeros:?}");
        let Some(zeros) = two.dual().zeros() else { unreachable!() };
        assert!(zeros.len() == 1 && (zeros[0].0 + 2.0).abs() < 1e-12, "{zeros:?}");
    }
}
