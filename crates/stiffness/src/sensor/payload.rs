//! What a force sensor carries, and what it reads at rest.

use crate::error::{StiffnessError, check_finite};
use crate::robot::{Wrench, check_wrench, stacked};
use nalgebra::{UnitQuaternion, Vector3};

/// The body beyond a force sensor (fixture, tool or workpiece) with what the sensor reads when nothing acts on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Payload {
    /// Mass in kg.
    pub mass: f64,
    /// Center of mass in the sensor's frame (m).
    pub center: Vector3<f64>,
    /// Reading without any load, in the sensor's axes.
    pub bias: Wrench,
}

impl Payload {
    /// Nothing carried, no bias.
    pub fn none() -> Self {
        Self { mass: 0.0, center: Vector3::zeros(), bias: Wrench::zeros() }
    }

    /// What the sensor reads at rest with no process force: bias and weight, in its axes at its origin.
    ///
    /// `orientation` is that of the sensor's axes in the base, `gravity` the acceleration in base axes (m/s²).
    pub fn reading(&self, orientation: &UnitQuaternion<f64>, gravity: &Vector3<f64>) -> Wrench {
        let force = self.mass * (orientation.inverse() * gravity);
        self.bias + stacked(&force, &self.center.cross(&force))
    }

    /// Refuses what is not finite or weighs less than nothing.
    pub(crate) fn check(&self) -> Result<(), StiffnessError> {
        check_wrench(&self.bias)?;
        if !(self.mass >= 0.0 && self.mass.is_finite()) {
            return Err(StiffnessError::NotFinite { what: "mass of the payload".into(), value: self.mass });
        }
        check_finite("center of the payload", &self.center)
    }
}
