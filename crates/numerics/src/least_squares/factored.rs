use crate::eigen::svd;
use nalgebra::{DMatrix, DVector};

/// The singular value decomposition of a matrix J, with small singular values taken for zero.
#[derive(Clone, Debug)]
pub struct Factored {
    u: DMatrix<f64>,
    singular_values: DVector<f64>,
    v_t: DMatrix<f64>,
    /// Singular values up to this are taken for zero.
    cut: f64,
}

impl Factored {
    /// Singular values up to the part `rank` of the largest are taken for zero. `None` where the matrix has no entries, one is not a
    /// finite number, or the iteration does not converge.
    pub fn new(matrix: &DMatrix<f64>, rank: f64) -> Option<Self> {
        let svd = svd(matrix)?;
        let cut = rank * svd.singular_values.max();
        Some(Self { u: svd.u?, singular_values: svd.singular_values, v_t: svd.v_t?, cut })
    }

    fn counts(&self, singular_value: f64) -> bool {
        singular_value > self.cut && singular_value > 0.0
    }

    /// How many singular values are not taken for zero.
    pub fn rank(&self) -> usize {
        self.singular_values.iter().filter(|s| self.counts(**s)).count()
    }

    /// The largest singular value.
    pub fn largest(&self) -> f64 {
        self.singular_values.max()
    }

    /// `(JᵀJ + μ)⁻¹ Jᵀ b`, the minimum of `‖J x − b‖² + μ ‖x‖²` for a damping μ; without damping the least of the x whose
    /// `‖J x − b‖` is least.
    pub fn solve(&self, b: &DVector<f64>, damping: f64) -> DVector<f64> {
        let mut along = self.u.tr_mul(b);
        for (c, &s) in along.iter_mut().zip(&self.singular_values) {
            // Not s / (s² + μ), whose squares underflow.
            *c = if self.counts(s) { *c / (s + damping / s) } else { 0.0 };
        }
        self.v_t.tr_mul(&along)
    }

    /// The part of x that J maps to zero.
    pub fn onto_null_space(&self, mut x: DVector<f64>) -> DVector<f64> {
        for (row, &s) in self.v_t.row_iter().zip(&self.singular_values) {
            if self.counts(s) {
                let direction = row.transpose();
                x -= &direction * direction.dot(&x);
            }
        }
        x
    }
}
