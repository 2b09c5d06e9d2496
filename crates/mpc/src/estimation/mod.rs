//! States, parameters and disturbances from measured outputs.

mod augmented;
mod estimate;
mod kalman;
mod problem;

pub use estimate::{Estimate, EstimateStatus, Estimator};
pub use kalman::ExtendedKalman;
pub use problem::{Disturbance, DisturbanceChannel, EstimatedParameter, EstimationProblem, MeasuredOutput, Outliers};
