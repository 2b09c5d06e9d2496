//! What is assumed of the plant, and how it is recorded.

use crate::Object;
use crate::area::AreaSettings;

/// What is assumed of the plant, and how it is recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingSettings {
    /// The object.
    pub object: Object,
    /// Friction coefficient.
    pub mu: f64,
    /// Samples per second.
    pub rate: f64,
    /// Standard deviation of the noise of the measured position, in m.
    pub position_noise: f64,
    /// Standard deviation of the noise of the measured yaw, in rad.
    pub angle_noise: f64,
    /// Whether the log has columns `der(X,2)`, `der(theta,1)`, `der(theta,2)`.
    pub derivatives: bool,
    /// How the plant is simulated; gravity and terms are part of the truth.
    pub area: AreaSettings,
}

impl Default for RecordingSettings {
    /// The reference disk, friction 0.3, 200 Hz with noise of 0.5 mm and 0.3°, no columns of derivatives.
    fn default() -> Self {
        Self {
            object: Object::REFERENCE,
            mu: 0.3,
            rate: 200.0,
            position_noise: 0.5e-3,
            angle_noise: 0.3f64.to_radians(),
            derivatives: false,
            area: AreaSettings::default(),
        }
    }
}
