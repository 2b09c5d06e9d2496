//! Bounds of the plate's motion.

use crate::PlateError;
use bracketry_mpc::PlannedTrajectory;
use serde::{Deserialize, Serialize};

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
    /// Whether all states of a move, `X` and `θ` at the places 6 and 8, keep the bounds.
    pub(super) fn keep(&self, trajectory: &PlannedTrajectory) -> bool {
        (1..=trajectory.steps()).all(|k| {
            let x = trajectory.x(k);
            x[6].abs() <= self.stroke && x[8].abs() <= self.tilt
        })
    }
}
