//! Equations as a triangular system: what each says beside those before it.

use bracketry_symbolic::{Expr, Pool, Symbol};
use nalgebra::{DMatrix, DVector};
use rustc_hash::FxHashMap;

use crate::algebra::matrix::solve;

/// An equation of which less than this part is left has slopes that depend, nearly, on those of the others.
const DEPENDENT: f64 = 1e-3;

/// Pivots below this part of the slopes are rounding.
const ROUNDING: f64 = 1e-13;

/// One equation, or a combination of several.
pub(crate) struct Combination {
    /// A factor for each equation.
    pub(crate) weights: DVector<f64>,
    /// The part of its gradient that is orthogonal to the gradients of the equations before it, which do not change in this direction to
    /// first order.
    pub(crate) direction: DVector<f64>,
    /// Its slope in this direction.
    pub(crate) slope: f64,
    /// The equation.
    row: usize,
    /// The equations that were combined with it, and the variable that each eliminates.
    pivots: Vec<(usize, usize)>,
}

impl Combination {
    /// Whether it is one of the equations as it stands.
    pub(crate) fn is_alone(&self) -> bool {
        self.pivots.is_empty()
    }

    /// The combination as an expression, with exact factors for the slopes at the given values of the variables. Rounded factors would
    /// leave the rounding of e^−x + √3 f beside f, instead of e^−x. `None` where the factors are too long to be written out.
    pub(crate) fn exact(
        &self,
        pool: &mut Pool,
        equations: &[Expr],
        variables: &[Symbol],
        at: &FxHashMap<Expr, Expr>,
    ) -> Option<Expr> {
        let mut slope = |row: usize, column: usize| {
            let slope = pool.diff(equations[row], variables[column]);
            pool.substitute(slope, at)
        };
        let columns = || self.pivots.iter().map(|&(_, column)| column);
        let slopes: Vec<Vec<Expr>> =
            columns().map(|column| self.pivots.iter().map(|&(row, _)| slope(row, column)).collect()).collect();
        let own: Vec<Expr> = columns().map(|column| slope(self.row, column)).collect();
        let factors = solve(pool, &slopes, &own)?;
        let parts: Vec<Expr> =
            self.pivots.iter().zip(factors).map(|(&(row, _), factor)| pool.mul(factor, equations[row])).collect();
        let parts = pool.sum(parts);
        Some(pool.sub(equations[self.row], parts))
    }
}

/// The equations with these gradients, one per row. An equation whose gradient depends, nearly, on those of others is
/// replaced by a combination with them from which their variables are eliminated: of f = 0 and c f + e^x = 0 only e^x is left, whose own
/// slope tells that it does not vanish.
pub(crate) fn combinations(gradients: &DMatrix<f64>) -> Vec<Combination> {
    let (m, n) = gradients.shape();
    let norms: Vec<f64> = gradients.row_iter().map(|row| row.norm()).collect();
    let scale = |i: usize| if norms[i] > 0.0 { 1.0 / norms[i] } else { 0.0 };
    let mut rows: Vec<DVector<f64>> = (0..m).map(|i| gradients.row(i).transpose() * scale(i)).collect();
    let mut weights: Vec<DVector<f64>> =
        (0..m).map(|i| DVector::from_fn(m, |k, _| if i == k { scale(i) } else { 0.0 })).collect();
    let mut left: Vec<usize> = (0..m).collect();
    let mut result = Vec::with_capacity(m);
    let mut pivots: Vec<(usize, usize)> = Vec::new();
    let mut before: Vec<DVector<f64>> = Vec::new();
    while let Some(place) = (0..left.len()).max_by(|&a, &b| rows[left[a]].amax().total_cmp(&rows[left[b]].amax())) {
        let pivot = left.swap_remove(place);
        let (row, weight) = (rows[pivot].clone(), weights[pivot].clone());
        let alone = norms[pivot] == 0.0 || row.norm() >= DEPENDENT;
        let (weights_of, gradient) = if alone {
            (DVector::from_fn(m, |i, _| f64::from(i == pivot)), gradients.row(pivot).transpose())
        } else {
            (weight.clone(), row.clone())
        };
        let mut direction = gradient.clone();
        for _ in 0..2 {
            for b in &before {
                direction.axpy(-b.dot(&direction), b, 1.0);
            }
        }
        let (slope, length) = (gradient.dot(&direction), direction.norm());
        let is_open = length > ROUNDING * if alone { norms[pivot] } else { 1.0 };
        let used = pivots.iter().copied().filter(|&(row, _)| !alone && weight[row] != 0.0).collect();
        let column = if n > 0 { row.icamax() } else { 0 };
        if row.amax() > ROUNDING {
            for &i in &left {
                let factor = rows[i][column] / row[column];
                if factor != 0.0 {
                    rows[i].axpy(-factor, &row, 1.0);
                    weights[i].axpy(-factor, &weight, 1.0);
                    rows[i][column] = 0.0;
                }
            }
            pivots.push((pivot, column));
        }
        if is_open {
            direction.unscale_mut(length);
            before.push(direction.clone());
        } else {
            direction.fill(0.0);
        }
        let slope = if is_open { slope / length } else { 0.0 };
        result.push(Combination { weights: weights_of, direction, slope, row: pivot, pivots: used });
    }
    result
}
