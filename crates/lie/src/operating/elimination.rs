//! Combinations of equations whose slopes do not depend on each other.

use nalgebra::{DMatrix, DVector};

/// An equation of which less than this part is left has slopes that depend, nearly, on those of the others.
const DEPENDENT: f64 = 1e-3;

/// Pivots below this part of the slopes are rounding.
const ROUNDING: f64 = 1e-13;

/// One equation, or a combination of several.
pub(crate) struct Combination {
    /// A factor for each equation.
    pub(crate) weights: DVector<f64>,
    /// Its gradient.
    pub(crate) gradient: DVector<f64>,
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
    while let Some(place) = (0..left.len()).max_by(|&a, &b| rows[left[a]].amax().total_cmp(&rows[left[b]].amax())) {
        let pivot = left.swap_remove(place);
        let (row, weight) = (rows[pivot].clone(), weights[pivot].clone());
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
        }
        let alone = norms[pivot] == 0.0 || row.norm() >= DEPENDENT;
        result.push(if alone {
            let weights = DVector::from_fn(m, |i, _| f64::from(i == pivot));
            Combination { weights, gradient: gradients.row(pivot).transpose() }
        } else {
            Combination { weights: weight, gradient: row }
        });
    }
    result
}
