//! Constraints beyond bounds: path constraints, norms, a set for the last state.

use super::bounds::{Bounds, Softness, positive, soft_weights};
use super::vector_function::VectorFunction;
use crate::error::{MpcError, check_length, check_value};
use nalgebra::{DMatrix, SymmetricEigen};
use std::ops::Range;

/// Grid points at which a constraint holds: those with an input when it depends on inputs, else those after the first,
/// whose state nothing can change.
fn grid_points(uses_inputs: bool, steps: usize) -> Range<usize> {
    if uses_inputs { 0..steps } else { 1..steps + 1 }
}

/// min ≤ g(x, u, t, r) ≤ max, at the grid points 0 … N−1 if g depends on an input, else 1 … N, or N alone. In a quadratic program it is
/// linearized.
#[derive(Clone)]
pub struct PathConstraint {
    /// Its name in results; empty where it has none.
    pub name: String,
    /// The function g, with one component.
    pub function: VectorFunction,
    /// Its bounds. Violations of hard ones are penalized per unit of g: scale g so that 1 is a large violation.
    pub bounds: Bounds,
    /// Whether it holds at the end of the horizon alone; g then uses no input.
    pub at_end: bool,
}

impl PathConstraint {
    /// Grid points at which it holds.
    pub fn grid_points(&self, steps: usize) -> Range<usize> {
        if self.at_end { steps..steps + 1 } else { grid_points(self.function.uses_inputs(), steps) }
    }
}

/// ‖g(x, u, t, r)‖ ≤ h(x, u, t, r) with the Euclidean norm, at the grid points 0 … N−1 if either depends on an input, else
/// 1 … N: limits on the length of an input vector, friction cones. In a quadratic program g and h are linearized and the
/// norm stays, as a second-order cone.
#[derive(Clone)]
pub struct NormConstraint {
    /// Its name in results; empty where it has none.
    pub name: String,
    /// The vector g.
    pub vector: VectorFunction,
    /// The limit h, with one component.
    pub limit: VectorFunction,
    /// What a violation ‖g‖ − h costs.
    pub softness: Softness,
}

impl NormConstraint {
    /// Grid points at which it holds.
    pub fn grid_points(&self, steps: usize) -> Range<usize> {
        grid_points(self.vector.uses_inputs() || self.limit.uses_inputs(), steps)
    }
}

/// (x_N − c)ᵀ P (x_N − c) ≤ α. Its violation is √((x_N − c)ᵀ P (x_N − c)) − √α.
#[derive(Clone, Debug, PartialEq)]
pub struct TerminalSet {
    /// P, row by row: symmetric, positive semidefinite.
    pub matrix: Vec<Vec<f64>>,
    /// The center c.
    pub center: Vec<f64>,
    /// The level α > 0.
    pub level: f64,
    /// What a violation v costs: linear·v + quadratic·v², without the factor dt of bounds along the horizon.
    pub softness: Softness,
}

/// Largest relative asymmetry and negative eigenvalue of a matrix that passes as symmetric and positive semidefinite.
const SEMIDEFINITE_TOLERANCE: f64 = 1e-9;

impl TerminalSet {
    fn eigen(&self) -> SymmetricEigen<f64, nalgebra::Dyn> {
        let n = self.center.len();
        SymmetricEigen::new(DMatrix::from_fn(n, n, |i, j| f64::midpoint(self.matrix[i][j], self.matrix[j][i])))
    }

    /// Rows of a matrix W with WᵀW = P, so that the set is ‖W (x − c)‖ ≤ √α; directions without weight are left out.
    pub(crate) fn root(&self) -> Vec<Vec<f64>> {
        let eigen = self.eigen();
        let largest = eigen.eigenvalues.amax();
        (0..self.center.len())
            .filter(|&i| eigen.eigenvalues[i] > SEMIDEFINITE_TOLERANCE * largest)
            .map(|i| eigen.eigenvectors.column(i).iter().map(|v| v * eigen.eigenvalues[i].sqrt()).collect())
            .collect()
    }

    pub(super) fn violation(&self, x: &[f64]) -> f64 {
        let e: Vec<f64> = x.iter().zip(&self.center).map(|(x, c)| x - c).collect();
        let square: f64 =
            self.matrix.iter().zip(&e).map(|(row, a)| a * row.iter().zip(&e).map(|(p, b)| p * b).sum::<f64>()).sum();
        (square.max(0.0).sqrt() - self.level.sqrt()).max(0.0)
    }

    pub(super) fn check(&self, states: usize) -> Result<(), MpcError> {
        check_length("the center of the terminal set", self.center.len(), states)?;
        check_length("the matrix of the terminal set", self.matrix.len(), states)?;
        positive("the level of the terminal set", self.level)?;
        for row in &self.matrix {
            check_length("a row of the terminal set's matrix", row.len(), states)?;
        }
        for &value in self.matrix.iter().flatten().chain(&self.center) {
            check_value(value.is_finite(), "an entry of the terminal set", value, "give a finite number")?;
        }
        let size = self.matrix.iter().flatten().fold(0.0, |a: f64, v| a.max(v.abs()));
        check_value(
            size != 0.0,
            "the largest entry of the terminal set's matrix",
            size,
            "give a matrix that is not zero",
        )?;
        for i in 0..states {
            for j in 0..i {
                let value = self.matrix[i][j] - self.matrix[j][i];
                check_value(
                    value.abs() <= SEMIDEFINITE_TOLERANCE * size,
                    format!("the asymmetry of the terminal set's matrix at ({i}, {j})"),
                    value,
                    "give a symmetric matrix",
                )?;
            }
        }
        let value = self.eigen().eigenvalues.min();
        check_value(
            value >= -SEMIDEFINITE_TOLERANCE * size,
            "the smallest eigenvalue of the terminal set's matrix",
            value,
            "give a positive semidefinite matrix",
        )?;
        soft_weights("the terminal set", self.softness)
    }
}
