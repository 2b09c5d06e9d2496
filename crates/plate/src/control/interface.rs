//! What controllers see and what they command.

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

impl Command {
    /// The motion of the plate with these accelerations from now on.
    #[must_use]
    pub fn applied_to(self, plate: &PlateKinematics) -> PlateKinematics {
        PlateKinematics {
            acceleration: self.displacement_acceleration,
            tilt_acceleration: self.tilt_acceleration,
            ..*plate
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

    /// Whether it has nothing to do but to bring the plate to rest and keep it there, as long as nothing pushes the object. Ask for
    /// commands all the same: a plate that nobody keeps at rest drifts.
    fn finished(&self) -> bool;
}
