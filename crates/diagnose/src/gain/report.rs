//! The gain in numbers.

use serde::Serialize;

/// How much better the extended model predicts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gain {
    /// What `before` and `after` are.
    pub metric: String,
    /// Prediction horizons in seconds.
    pub horizons_s: Vec<f64>,
    /// Error of the given model with refitted parameters at each horizon.
    pub before: Vec<f64>,
    /// Error of the extended model.
    pub after: Vec<f64>,
    /// Error of the model as it was given, parameters unchanged.
    pub as_given: Vec<f64>,
    /// Whether the data played no part in any fit.
    pub held_out: bool,
    /// Predictions at each horizon.
    pub predictions: Vec<usize>,
    /// Force error of the given model with refitted parameters, relative to the applied force.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equation_error_before: Option<f64>,
    /// Force error of the extended model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equation_error_after: Option<f64>,
    /// Force error of the model as it was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equation_error_as_given: Option<f64>,
    /// Bandwidth of the derivatives behind the force error, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equation_bandwidth_hz: Option<f64>,
}
