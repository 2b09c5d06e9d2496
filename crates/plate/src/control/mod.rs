//! Feedback control of the object's pose by the plate's motion: what controllers see, what they command, within what bounds.

mod friction_bank;
mod move_problem;
mod oscillation;
mod planner;
mod pose_controller;
mod replay;
mod rounded_contact;
mod settings;

pub use pose_controller::PoseController;
pub use rounded_contact::RoundedContact;
pub use settings::{MoveReport, PoseReport, PoseSettings, PoseStatus};

use crate::{PlateError, PlateKinematics};
use serde::{Deserialize, Serialize};

/// What a controller sees at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// Pose of the object in the plate frame, `x, y` (m), `phi` (rad, not wrapped), with the noise of the sensor; NaN where
    /// lost.
    pub object: [f64; 3],
    /// Displacement and tilt of the plate with their rates, exact. The accelerations are those that act from now on if no new
    /// command arrives.
    pub plate: PlateKinematics,
}

/// Accelerations of the plate, held constant over a period.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// `X''` in m/s².
    pub displacement_acceleration: f64,
    /// `θ''` in rad/s².
    pub tilt_acceleration: f64,
}

/// Bounds of the plate's motion, symmetric about zero.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlateLimits {
    /// Greatest `|X|` in m.
    pub stroke: f64,
    /// Greatest `|θ|` in rad.
    pub tilt: f64,
    /// Greatest `|X''|` in m/s².
    pub displacement_acceleration: f64,
    /// Greatest `|θ''|` in rad/s².
    pub tilt_acceleration: f64,
}

impl Default for PlateLimits {
    /// 0.1 m, 20°, 15 m/s², 60 rad/s².
    fn default() -> Self {
        Self { stroke: 0.1, tilt: 20f64.to_radians(), displacement_acceleration: 15.0, tilt_acceleration: 60.0 }
    }
}

impl PlateLimits {
    /// Checks that all bounds are positive and finite.
    ///
    /// # Errors
    /// [`PlateError::BadNumber`] for one that is not.
    pub fn validate(&self) -> Result<(), PlateError> {
        let bounds = [
            ("stroke", self.stroke),
            ("tilt", self.tilt),
            ("displacement_acceleration", self.displacement_acceleration),
            ("tilt_acceleration", self.tilt_acceleration),
        ];
        match bounds.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
            Some((name, value)) => Err(PlateError::BadNumber { name, value }),
            None => Ok(()),
        }
    }
}

/// A feedback law that moves the plate so that the object reaches a pose and stays there.
///
/// The loop samples every [`PlateController::period`]. The command of a measurement acts over one period, from the sampling
/// instant on or, with a delay, some samples later; the controller is told the delay when it is made. The plate stops when the
/// controller has finished and the plate is at rest.
pub trait PlateController {
    /// Sampling period in s, constant.
    fn period(&self) -> f64;

    /// The command for a measurement, within the controller's limits.
    ///
    /// # Errors
    /// [`PlateError`] for misuse only. Lost measurements and failing solvers are the controller's to deal with.
    fn command(&mut self, measurement: &Measurement) -> Result<Command, PlateError>;

    /// Whether it will only bring the plate to rest, or keep it there.
    fn finished(&self) -> bool;
}
