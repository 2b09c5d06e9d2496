//! The unknowns of a fit: refitted parameters, then the coefficients of effects.

use crate::effect::{Coefficient, Role};
use bracketry_system::{Parameter, System};

/// Standard deviation of the prior of a parameter over its nominal value. Weak: it decides only where the data do not.
const PARAMETER_PRIOR: f64 = 0.5;
/// A parameter stays within this factor of its value: a refit is a calibration. Windows that are short against the time constants
/// of a model that is wrong by far are explained best by their initial states alone, with masses beyond all bounds.
const LARGEST_CHANGE: f64 = 3.0;
/// Standard deviation of the prior of an effect's amplitude over its scale.
const AMPLITUDE_PRIOR: f64 = 100.0;
/// Standard deviation of the prior of an effect's shape over its scale.
const SHAPE_PRIOR: f64 = 2.0;

/// A number that is fitted.
#[derive(Clone, Debug)]
pub(super) struct Unknown {
    pub(super) name: String,
    /// The model's value, or where an effect vanishes; the mean of the prior.
    pub(super) nominal: f64,
    /// Typical size.
    pub(super) scale: f64,
    pub(super) min: f64,
    pub(super) max: f64,
    /// Standard deviation of the prior.
    pub(super) prior: f64,
    /// Where the fit begins.
    pub(super) start: f64,
}

impl Unknown {
    pub(super) fn parameter(system: &System, parameter: &Parameter) -> Self {
        let number = |r: &bracketry_symbolic::Rational| r.to_f64().value();
        let nominal = number(&parameter.value);
        let min = parameter.min.as_ref().map_or(f64::NEG_INFINITY, number);
        let max = parameter.max.as_ref().map_or(f64::INFINITY, number);
        let range = max - min;
        let (scale, prior) = if nominal != 0.0 {
            (nominal.abs(), PARAMETER_PRIOR * nominal.abs())
        } else if range.is_finite() && range > 0.0 {
            (0.5 * range, 0.5 * range)
        } else {
            (1.0, 1.0)
        };
        let (min, max) = match nominal.partial_cmp(&0.0) {
            Some(std::cmp::Ordering::Greater) => (min.max(nominal / LARGEST_CHANGE), max.min(LARGEST_CHANGE * nominal)),
            Some(std::cmp::Ordering::Less) => (min.max(LARGEST_CHANGE * nominal), max.min(nominal / LARGEST_CHANGE)),
            _ => (min, max),
        };
        Self { name: system.symbol_name(parameter.symbol).to_owned(), nominal, scale, min, max, prior, start: nominal }
    }

    pub(super) fn coefficient(c: &Coefficient) -> Self {
        let prior = match c.role {
            Role::Amplitude => AMPLITUDE_PRIOR * c.scale,
            Role::Shape => SHAPE_PRIOR * c.scale.max(c.nominal.abs()),
        };
        Self {
            name: c.name.clone(),
            nominal: c.nominal,
            scale: c.scale,
            min: c.min,
            max: c.max,
            prior,
            start: c.nominal,
        }
    }

    /// A value within the bounds.
    pub(super) fn bounded(&self, value: f64) -> f64 {
        value.max(self.min).min(self.max)
    }
}

/// Whether a parameter is a constant of nature that no data should move: the acceleration of gravity, by its name and its
/// value, or by its unit and its value.
pub(super) fn is_natural_constant(system: &System, parameter: &Parameter) -> bool {
    let value = parameter.value.to_f64().value();
    let name = system.symbol_name(parameter.symbol);
    let unit = parameter.unit.as_deref().unwrap_or("").replace(' ', "");
    let acceleration = matches!(unit.as_str(), "m/s^2" | "m/s**2" | "m/s2" | "m/s²" | "ms^-2" | "m*s^-2");
    (9.7..=9.9).contains(&value) && (name == "g" || acceleration)
}
