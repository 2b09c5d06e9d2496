//! The vibrating hyper-plate: published model, experiments, objects and scenarios.
//!
//! A plate translates along its x axis, `X(t)`, and rotates about the same axis, `theta(t)`. An object lies on it without
//! being grasped; its position `(x, y)` and yaw `phi` in the plate frame are moved by dry friction alone.

mod area;
mod baseline;
mod body;
mod control;
mod error;
mod experiment;
mod friction;
mod logs;
mod model;
mod monte_carlo;
mod motion;
mod object;
mod plant;

pub use area::{
    AreaContact, AreaEvent, AreaOutcome, AreaRecord, AreaSample, AreaSettings, EnergyBalance, Footprint, Load, Scheme,
    Support,
};
pub use baseline::{AveragedController, Cycle, CycleGrid, CycleMap, TwoStepController};
pub use body::{
    BodyEvent, BodyEventKind, BodyOnPlate, BodySettings, BodyStop, ObjectMode, ObjectOnPlate, ObjectStop, PlateFrame,
    RigidState,
};
pub use control::{
    Command, Measurement, MoveReport, PlateController, PlateLimits, PoseController, PoseReport, PoseSettings,
    PoseStatus, RoundedContact,
};
pub use error::PlateError;
pub use experiment::{
    AmplitudeLaw, AmplitudeStep, Establishing, Experiment, Limits, Map, MeanVelocity, Run, Stage, Summary, TwoStep,
    linspace, mean_velocity, summarise, sweep, two_step, two_step_on, velocity_field,
};
pub use friction::Friction;
pub use logs::{HiddenEffect, LogSettings, PlateLog, multisine, plate_log};
pub use model::{
    Energy, FlatContact, GRAVITY, Terms, energy, first_principles, flat_contact, normal_load, published, reduced,
};
pub use monte_carlo::{
    ControlSample, PoseRange, Push, PushRange, Quantiles, Scenario, Share, Tolerance, Trial, TrialFile, TrialOutcome,
    TrialReport, TrialRun, TrialSample, TrialSetup, TrialSummary, Utilisation, WallTimes, at_rest, median_time_ratio,
    pose_error, quantile, run_trial, run_trials, time_to_target,
};
pub use motion::{Drive, ExpressionMotion, Harmonic, PeriodicMotion, PlateKinematics, PlateMotion};
pub use object::{Object, Quadrature, Shape, ShapeError, Vertices};
pub use plant::{AreaPlant, Course, ModelPlant, Plant, STATES};
