//! Controllers against the area-contact plant in random trials.

mod batch;
mod criterion;
mod scenario;
mod statistics;
mod trial;

pub use batch::{TrialReport, TrialSummary, WallTimes, median_time_ratio, run_trials};
pub use criterion::{Tolerance, TrialSample, at_rest, pose_error, time_to_target};
pub use scenario::{PoseRange, Push, PushRange, Scenario, Trial, TrialFile};
pub use statistics::{Quantiles, Share, quantile};
pub use trial::{ControlSample, TrialOutcome, TrialRun, TrialSetup, Utilization, run_trial};
