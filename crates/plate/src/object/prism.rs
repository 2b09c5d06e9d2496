//! The object on the plate.

use super::bearing::Bearing;
use super::shape::Shape;
use crate::PlateError;
use serde::{Deserialize, Serialize};

/// A right prism that lies on the plate: the shape of its base, the height of its center of mass, its mass, and where it presses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Object {
    /// Shape of the base.
    pub shape: Shape,
    /// Height `h` of the center of mass above the plate in m, half the thickness; 0 for an object without thickness.
    pub height: f64,
    /// Mass in kg.
    pub mass: f64,
    /// Where it presses on the plate.
    #[serde(default)]
    pub bearing: Bearing,
    /// The center of mass from the center of the shape, own axes, in m. Poses are those of the center of the shape, and so is
    /// the center of a scaled bearing; the second moments of the mass about its center stay those of the uniform prism.
    #[serde(default)]
    pub center_of_mass: [f64; 2],
}

impl Object {
    /// The object of the logs and reference results: a disk of radius 0.12 m, 5 mm thick, 0.2 kg.
    pub const REFERENCE: Object = Object {
        shape: Shape::REFERENCE_DISK,
        height: 0.0025,
        mass: 0.2,
        bearing: Bearing::Footprint,
        center_of_mass: [0.0; 2],
    };

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
        if let Some(value) = self.center_of_mass.into_iter().find(|x| !x.is_finite()) {
            return Err(PlateError::BadNumber { name: "center_of_mass", value });
        }
        Ok(())
    }

    /// Checks that the object stands on its whole footprint about its center of mass, which is all that some models know.
    pub(crate) fn stands_evenly(&self) -> Result<(), PlateError> {
        if self.bearing == Bearing::Footprint && self.center_of_mass == [0.0; 2] {
            Ok(())
        } else {
            Err(PlateError::UnevenBearing)
        }
    }

    /// The center of mass from the center of the shape at yaw `phi`, plate axes, in m.
    pub(crate) fn center_of_mass_at(&self, phi: f64) -> [f64; 2] {
        let ([x, y], (s, c)) = (self.center_of_mass, phi.sin_cos());
        [c * x - s * y, s * x + c * y]
    }

    /// Second moment of the mass along the normal about its center, per mass: `h²/3`.
    pub fn normal_moment(&self) -> f64 {
        self.height * self.height / 3.0
    }
}
