//! What is chosen for control on the exact stick–slip flow.

use crate::controller::FailurePolicy;
use crate::error::{MpcError, check_value};
use crate::qp::QpSettings;
use bracketry_symbolic::StopFlag;

/// Settings of a [`StickSlipController`](super::StickSlipController).
#[derive(Clone, Debug, PartialEq)]
pub struct StickSlipSettings {
    /// Largest number of quadratic programs per sample along the plan; 1 is the real-time iteration. From sample to sample the
    /// plan changes little, so that two or three mostly do.
    pub iterations: usize,
    /// Largest number of quadratic programs that refine the first plan.
    pub initial_iterations: usize,
    /// The iteration stops when a step lowers the cost by less than this fraction of it.
    pub tolerance: f64,
    /// Widths of the smoothed problems whose solutions the first plan is chosen from, from wide to narrow; the first of them
    /// also shows in which directions what sticks wants to move. None: plans start from the guess alone and never break
    /// loose by themselves.
    pub smoothing: Vec<f64>,
    /// Width by which unit vectors σ/|σ| are rounded, in the unit of σ.
    pub rounding: f64,
    /// Names of the model's parameters that the problem gives over the horizon, or an estimator hands over.
    pub live_parameters: Vec<String>,
    /// What is applied when a sample has no solution.
    pub failure: FailurePolicy,
    /// Input of rest; zero, or the bound closest to it, when empty.
    pub rest_input: Vec<f64>,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
    /// Once it is raised, planning ends with [`MpcError::Stopped`].
    pub stop: StopFlag,
}

impl Default for StickSlipSettings {
    fn default() -> Self {
        Self {
            iterations: 20,
            initial_iterations: 50,
            tolerance: 1e-6,
            smoothing: vec![0.1, 0.01],
            rounding: 1e-3,
            live_parameters: Vec::new(),
            failure: FailurePolicy::default(),
            rest_input: Vec::new(),
            qp: QpSettings::default(),
            stop: StopFlag::default(),
        }
    }
}

impl StickSlipSettings {
    pub(super) fn check(&self) -> Result<(), MpcError> {
        for &w in self.smoothing.iter().chain([&self.rounding]) {
            check_value(w > 0.0 && w.is_finite(), "a smoothing width", w, "give a positive number")?;
        }
        Ok(())
    }
}
