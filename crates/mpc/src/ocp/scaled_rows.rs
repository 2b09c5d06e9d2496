//! References and parameters over a time that is scaled by an input.

use crate::trajectory::PlannedTrajectory;
use bracketry_symbolic::{Expr, Pool};
use std::sync::Arc;

/// Rows of parameters and references of a problem; none where there are no columns.
pub(crate) struct Rows {
    pub(crate) parameters: Vec<Vec<f64>>,
    pub(crate) references: Vec<Vec<f64>>,
}

/// What is known over time t, in a problem whose time is t = σ τ with an input σ that is held over the horizon.
///
/// A quantity r(σ τ_k) enters the functions of the problem as a + b σ + c σ² with coefficients a, b, and c at every grid point: its Taylor
/// polynomial at the σ of the trajectory at which the functions are evaluated. So values and first and second derivatives are exact there.
#[derive(Clone)]
pub(crate) struct ScaledRows {
    /// Index of σ.
    input: usize,
    rows: Arc<dyn Fn(f64) -> Rows + Send + Sync>,
    /// σ of the rows that the problem has now.
    at: f64,
}

impl ScaledRows {
    /// The rows by σ; the problem has those of σ = 1.
    pub(crate) fn new(input: usize, rows: impl Fn(f64) -> Rows + Send + Sync + 'static) -> Self {
        Self { input, rows: Arc::new(rows), at: 1.0 }
    }

    /// The rows in the time of a trajectory; none where the problem has them already.
    pub(super) fn along(&mut self, trajectory: &PlannedTrajectory) -> Option<Rows> {
        let scale = trajectory.u(0)[self.input];
        if scale == self.at {
            return None;
        }
        self.at = scale;
        Some((self.rows)(scale))
    }
}

/// Name of the coefficient of σ to this power in a quantity over scaled time.
pub(crate) fn coefficient_name(name: &str, power: u32) -> String {
    if power == 0 { name.to_owned() } else { format!("{name}#{power}") }
}

/// A quantity over scaled time by its coefficients.
pub(crate) fn over_scaled_time(pool: &mut Pool, name: &str, scale: Expr) -> Expr {
    let [a, b, c] = [0, 1, 2].map(|power| pool.var(&coefficient_name(name, power)));
    let inner = pool.mul(scale, c);
    let inner = pool.add(b, inner);
    let rest = pool.mul(scale, inner);
    pool.add(a, rest)
}
