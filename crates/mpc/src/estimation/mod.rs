//! States, parameters and disturbances from measured outputs.

mod augmented;
mod estimate;
mod kalman;
mod moving_horizon;
mod problem;

pub use estimate::{Estimate, EstimateStatus, Estimator};
pub use kalman::ExtendedKalman;
pub use moving_horizon::{MovingHorizon, MovingHorizonSettings};
pub use problem::{Disturbance, DisturbanceChannel, EstimatedParameter, EstimationProblem, MeasuredOutput, Outliers};
