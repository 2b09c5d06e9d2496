//! Plate motions as text with named numbers.

use super::expression::ExpressionMotion;
use crate::PlateError;
use bracketry_sim::Inputs;

/// The motion of the plate as text: displacement `X` (m) and tilt `theta` (rad) as expressions of the time `t` and of
/// named numbers that can be changed while the plate moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// `X(t)` in meters.
    pub displacement: String,
    /// `theta(t)` in radians.
    pub tilt: String,
    /// The named numbers with their values at first.
    pub numbers: Vec<(String, f64)>,
}

impl Drive {
    /// A plate that stays level and at its place.
    pub fn still() -> Self {
        Self { displacement: "0".into(), tilt: "0".into(), numbers: Vec::new() }
    }

    /// The motion with its derivatives, compiled.
    ///
    /// # Errors
    /// [`PlateError::Motion`] if an expression cannot be read.
    pub fn motion(&self) -> Result<ExpressionMotion, PlateError> {
        let numbers: Vec<(&str, f64)> = self.numbers.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        ExpressionMotion::new(&self.displacement, &self.tilt, &numbers)
    }

    /// The motion as inputs `X`, `theta` of a model.
    pub fn inputs(&self) -> Inputs {
        let inputs = Inputs::new().expression("X", &self.displacement).expression("theta", &self.tilt);
        self.numbers.iter().fold(inputs, |inputs, (name, value)| inputs.live(name, *value))
    }
}
