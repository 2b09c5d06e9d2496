//! Nonlinear least squares.

use bracketry_numerics::least_squares::{self, Damping, Problem, Settings, Status};
use nalgebra::{DMatrix, DVector};

/// Relative decrease of the sum of squares below which the fit has converged.
const CONVERGED: f64 = 1e-8;
/// Largest change of a parameter in a step; the parameters are of size 1 (logarithms, or scaled).
const LONGEST: f64 = 2.0;

/// Where the iteration ended.
pub(super) struct Minimum {
    pub(super) parameters: DVector<f64>,
    /// Derivative of the residuals there.
    pub(super) jacobian: DMatrix<f64>,
    pub(super) iterations: usize,
    pub(super) converged: bool,
}

/// Minimizes `‖residuals(p)‖²`. `None` from `residuals` makes a step too long.
pub(super) fn minimize(
    mut residuals: impl FnMut(&DVector<f64>) -> Option<DVector<f64>>,
    start: &DVector<f64>,
    most_iterations: usize,
) -> Option<Minimum> {
    let settings = Settings {
        damping: Damping { lower: 0.2, raise: 4.0, ..Damping::default() },
        iterations: most_iterations,
        scaled: true,
        longest: LONGEST,
        settled: CONVERGED,
        ..Settings::default()
    };
    let found = least_squares::minimize(&mut residuals, start, &settings)?;
    Some(Minimum {
        jacobian: residuals.jacobian(&found.at, &found.residual)?,
        parameters: found.at,
        iterations: found.iterations,
        converged: matches!(found.status, Status::Converged | Status::Stalled),
    })
}
