//! The object on the plate.

use super::shape::Shape;
use crate::PlateError;
use serde::{Deserialize, Serialize};

/// A uniform right prism that lies on the plate: the shape of its base, the height of its center of mass, its mass.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Shape of the base.
    pub shape: Shape,
    /// Height `h` of the center of mass above the plate in m, half the thickness; 0 for an object without thickness.
    pub height: f64,
    /// Mass in kg.
    pub mass: f64,
}

impl Object {
    /// The object of the logs and reference results: a disk of radius 0.12 m, 5 mm thick, 0.2 kg.
    pub const REFERENCE: Object = Object { shape: Shape::REFERENCE_DISK, height: 0.0025, mass: 0.2 };

    /// Checks lengths and mass.
    ///
    /// # Errors
    /// [`PlateError::BadNumber`] for a length or mass that is not positive, [`PlateError::NegativeNumber`] for a height that
    /// is negative or not finite.
    pub fn validate(&self) -> Result<(), PlateError> {
        self.shape.validate()?;
        if !(self.height.is_finite() && self.height >= 0.0) {
            return Err(PlateError::NegativeNumber { name: "height", value: self.height });
        }
        if !(self.mass.is_finite() && self.mass > 0.0) {
            return Err(PlateError::BadNumber { name: "mass", value: self.mass });
        }
        Ok(())
    }

    /// Second moment of the mass along the normal about its center, per mass: `h²/3`.
    pub fn normal_moment(&self) -> f64 {
        self.height * self.height / 3.0
    }
}
