//! States, parameters and disturbances from measured outputs.

mod augmented;
mod estimate;
mod kalman;
mod moving_horizon;
mod observability;
mod offset_free;
mod output_feedback;
mod problem;
mod targets;

pub use estimate::{Estimate, EstimateStatus, Estimator};
pub use kalman::ExtendedKalman;
pub use moving_horizon::{MovingHorizon, MovingHorizonSettings};
pub use offset_free::OffsetFree;
pub use output_feedback::OutputFeedback;
pub use problem::{Disturbance, DisturbanceChannel, EstimatedParameter, EstimationProblem, MeasuredOutput, Outliers};
pub use targets::{SteadyTarget, TargetCalculator, TargetStatus};
