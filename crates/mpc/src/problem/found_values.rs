//! The end time, parameters, and initial states that a plan decided on.

use bracketry_symbolic::Named;
use serde::Serialize;

/// Values of what a problem leaves free, as its plan found them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundValues {
    /// End time, s; none where it was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub end_time: Option<f64>,
    /// Parameters of the model.
    #[serde(skip_serializing_if = "Named::is_empty")]
    pub parameters: Named<f64>,
    /// Initial states that were left free.
    #[serde(skip_serializing_if = "Named::is_empty")]
    pub initial_states: Named<f64>,
    /// How the solution process ended.
    pub status: String,
    /// Whether it converged.
    #[serde(skip)]
    pub converged: bool,
    /// Steps of the interior-point method, before the programs that confirm where it ends.
    pub interior_point_steps: usize,
    /// Number of quadratic programs.
    pub programs: usize,
    /// Stage and terminal cost.
    pub cost: f64,
    /// Time taken, s.
    pub seconds: f64,
}
