//! Systems, effects and logs drawn at random: what tests and examples are tried on.

mod baseline;
mod error;
mod monte_carlo;
mod slider;

pub use baseline::{AveragedController, Cycle, CycleGrid, CycleMap, TwoStepController};
pub use error::TrialError;
pub use monte_carlo::{
    ControlSample, PoseRange, Push, PushRange, Quantiles, Scenario, Share, Tolerance, Trial, TrialFile, TrialOutcome,
    TrialReport, TrialRun, TrialSample, TrialSetup, TrialSummary, Utilization, WallTimes, at_rest, median_time_ratio,
    pose_error, quantile, run_trial, run_trials, time_to_target,
};
pub use slider::{
    Choice, Excitation, Hidden, Score, Slider, SliderEffect, SliderLog, SliderSensors, SliderTrial, SliderTruth,
    SyntheticError,
};
