//! Periodic plate motions.

use super::drive::Drive;
use crate::PlateError;
use serde::{Deserialize, Serialize};

/// One harmonic of a periodic motion: `amplitude · sin(k·2πf t + phase)`, `k` its place in the list, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Harmonic {
    /// Amplitude in m or rad.
    pub amplitude: f64,
    /// Phase in rad.
    #[serde(default)]
    pub phase: f64,
}

/// A periodic plate motion: Fourier series of the displacement and of the tilt.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PeriodicMotion {
    /// Frequency in Hz.
    pub frequency: f64,
    /// Harmonics of the displacement, the first at `frequency`.
    #[serde(default)]
    pub displacement: Vec<Harmonic>,
    /// Harmonics of the tilt.
    #[serde(default)]
    pub tilt: Vec<Harmonic>,
    /// Mean tilt in rad.
    #[serde(default)]
    pub mean_tilt: f64,
}

impl PeriodicMotion {
    /// The motion as expressions of `t`.
    ///
    /// # Errors
    /// [`PlateError::BadNumber`] for a frequency that is not positive, [`PlateError::BadMotionNumber`] for other numbers
    /// that are not finite.
    pub fn drive(&self) -> Result<Drive, PlateError> {
        if !(self.frequency.is_finite() && self.frequency > 0.0) {
            return Err(PlateError::BadNumber { name: "frequency", value: self.frequency });
        }
        let all = self.displacement.iter().chain(&self.tilt).flat_map(|h| [h.amplitude, h.phase]);
        if let Some(value) = all.chain([self.mean_tilt]).find(|value| !value.is_finite()) {
            return Err(PlateError::BadMotionNumber { name: "harmonic".into(), value });
        }
        let series = |harmonics: &[Harmonic], mean: f64| {
            harmonics.iter().enumerate().fold(format!("({mean})"), |sum, (k, h)| {
                format!("{sum} + ({})*sin({}*pi*f*t + ({}))", h.amplitude, 2 * (k + 1), h.phase)
            })
        };
        Ok(Drive {
            displacement: series(&self.displacement, 0.0),
            tilt: series(&self.tilt, self.mean_tilt),
            numbers: vec![("f".into(), self.frequency)],
        })
    }
}
