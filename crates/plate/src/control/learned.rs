//! What a controller learns of an object and of its camera.

use crate::{Object, PlateError};

/// Parameters: logarithms of friction coefficient and scale of the bearing, center of mass along the object's axes (m), latency
/// of the camera (s).
pub(super) const PARAMETERS: usize = 5;
/// Those of the object; the latency is none.
pub(super) const OF_OBJECT: usize = 4;
/// The place of the latency.
pub(super) const LATENCY: usize = 4;

/// Least and greatest values that are believed: friction 0.05 to 1.2, scale 0.35 to 1.7, 25 mm, 80 ms.
const BOUNDS: [[f64; 2]; PARAMETERS] = [[-2.996, 0.182], [-1.05, 0.531], [-0.025, 0.025], [-0.025, 0.025], [0.0, 0.08]];

/// How uncertain a controller is at first about what it can learn, as standard deviations; 0 for what is known exactly. What
/// motion does not show stays as assumed at first: bearing and center of mass of the object, no latency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Of the scale of the bearing, as a share of it: how far out the pressure stands, and with it friction against the spin.
    pub scale: f64,
    /// Of the center of mass along each of the object's axes, in m.
    pub center_of_mass: f64,
    /// Of the latency of the measured poses, in s.
    pub latency: f64,
}

impl Uncertainty {
    /// Everything but friction is known.
    pub const NONE: Self = Self { scale: 0.0, center_of_mass: 0.0, latency: 0.0 };
}

impl Default for Uncertainty {
    /// A third of the scale, 4 mm, 10 ms.
    fn default() -> Self {
        Self { scale: 0.33, center_of_mass: 4e-3, latency: 0.01 }
    }
}

/// A learned number with its standard deviation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// What has been learned.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Learned {
    /// Friction coefficient.
    pub mu: Estimate,
    /// Scale of the bearing relative to the one assumed at first.
    pub scale: Estimate,
    /// Center of mass from the center of the shape, along the object's own axes, in m.
    pub center_of_mass: [Estimate; 2],
    /// Latency of the measured poses in s.
    pub latency: Estimate,
    /// Time in s by which the motion of the plate lags behind the commands, beyond the known delay.
    pub servo_lag: Estimate,
}

/// Values of the parameters.
pub(super) type Parameters = [f64; PARAMETERS];

/// The parameters assumed at first.
pub(super) fn first_belief(object: &Object, mu: f64) -> Parameters {
    let [x, y] = object.center_of_mass;
    [mu.max(1e-3).ln(), 0.0, x, y, 0.0]
}

/// The object that the parameters tell of, and its friction coefficient.
pub(super) fn object_of(first: &Object, parameters: &Parameters) -> (Object, f64) {
    let [mu, scale, x, y, _] = *parameters;
    let mut object = first.clone();
    if scale != 0.0 {
        object.bearing = first.bearing.scaled(scale.exp());
    }
    object.center_of_mass = [x, y];
    (object, mu.exp())
}

/// Parameters within the assumed ranges, and nothing else changed.
pub(super) fn bounded(parameters: &mut Parameters) {
    for (value, [least, most]) in parameters.iter_mut().zip(BOUNDS) {
        *value = value.clamp(least, most);
    }
}

/// Checks the deviations.
pub(super) fn validate(uncertainty: &Uncertainty, mu_deviation: f64) -> Result<(), PlateError> {
    let Uncertainty { scale, center_of_mass, latency } = *uncertainty;
    let all = [
        ("mu_deviation", mu_deviation),
        ("uncertainty of the scale", scale),
        ("uncertainty of the center of mass", center_of_mass),
        ("uncertainty of the latency", latency),
    ];
    match all.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        Some((name, value)) => Err(PlateError::NegativeNumber { name, value }),
        None => Ok(()),
    }
}
