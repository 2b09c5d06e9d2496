//! Settings of the body on the plate.

use crate::PlateError;
use crate::model::GRAVITY;

/// How a body on the plate is simulated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodySettings {
    /// Gravity in m/s², positive down.
    pub gravity: f64,
    /// Restitution of Newton's law of impact, 0 to 1.
    pub restitution: f64,
    /// Longest step while points touch, in s. The motion in contact is of first order in it; times of impact are events.
    pub contact_step: f64,
    /// Longest step in flight, in s; the flight itself is exact, the plate's motion must be resolved.
    pub flight_step: f64,
    /// Speed of approach in m/s below which an impact ends without rebound. A sequence of impacts that accumulates in time
    /// ends here, at most `2 rest_speed/(g (1 − e))` before its limit.
    pub rest_speed: f64,
    /// Number of contact points, about, on a face that lies flat; see [`crate::Shape::quadrature`].
    pub points: usize,
    /// Most steps of one call.
    pub max_steps: usize,
}

impl Default for BodySettings {
    fn default() -> Self {
        Self {
            gravity: GRAVITY,
            restitution: 0.0,
            contact_step: 2e-4,
            flight_step: 1e-3,
            rest_speed: 1e-6,
            points: 48,
            max_steps: 5_000_000,
        }
    }
}

impl BodySettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// [`PlateError::BadNumber`] for one that must be positive, [`PlateError::Restitution`] for a restitution outside 0 to 1.
    pub fn validate(&self) -> Result<(), PlateError> {
        let positive = [
            ("gravity", self.gravity),
            ("contact_step", self.contact_step),
            ("flight_step", self.flight_step),
            ("rest_speed", self.rest_speed),
            ("max_steps", self.max_steps as f64),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(PlateError::BadNumber { name, value });
            }
        }
        if !(0.0..=1.0).contains(&self.restitution) {
            return Err(PlateError::Restitution { value: self.restitution });
        }
        Ok(())
    }
}
