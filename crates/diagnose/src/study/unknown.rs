//! The unknowns of a fit: refitted parameters, then the coefficients of effects.

use crate::effect::{Coefficient, Role};
use crate::settings::PriorSettings;
use bracketry_system::{Parameter, System};

/// A number that is fitted.
#[derive(Clone, Debug)]
pub(super) struct Unknown {
    pub(super) name: String,
    /// The model's value, or where an effect vanishes; the mean of the prior.
    pub(super) nominal: f64,
    /// Typical size.
    pub(super) scale: f64,
    /// Limits that the model file or the effect gives; infinite where there is none.
    pub(super) min: f64,
    pub(super) max: f64,
    /// Whether it keeps near the value it comes from where there is no limit.
    calibrated: bool,
    /// Standard deviation of the prior.
    pub(super) prior: f64,
    /// Initial value of the fit.
    pub(super) start: f64,
}

impl Unknown {
    pub(super) fn parameter(system: &System, parameter: &Parameter, priors: &PriorSettings) -> Self {
        let number = |r: &bracketry_symbolic::Rational| r.to_f64().value();
        let nominal = number(&parameter.value);
        let min = parameter.min.as_ref().map_or(f64::NEG_INFINITY, number);
        let max = parameter.max.as_ref().map_or(f64::INFINITY, number);
        let range = max - min;
        let (scale, prior) = if nominal != 0.0 {
            (nominal.abs(), priors.parameter * nominal.abs())
        } else if range.is_finite() && range > 0.0 {
            (0.5 * range, 0.5 * range)
        } else {
            (1.0, 1.0)
        };
        let name = system.symbol_name(parameter.symbol).to_owned();
        Self { name, nominal, scale, min, max, calibrated: nominal != 0.0, prior, start: nominal }
    }

    pub(super) fn coefficient(c: &Coefficient, priors: &PriorSettings) -> Self {
        let prior = match c.role {
            _ if c.settled().is_some() => priors.one_value * c.scale,
            Role::Amplitude => priors.amplitude * c.scale,
            Role::Shape => priors.shape * c.scale.max(c.nominal.abs()),
        };
        Self {
            name: c.name.clone(),
            nominal: c.settled().unwrap_or(c.nominal),
            scale: c.scale,
            min: c.min,
            max: c.max,
            calibrated: false,
            prior,
            start: c.nominal,
        }
    }

    /// Whether it has one value only.
    pub(super) fn is_settled(&self) -> bool {
        self.min == self.max
    }

    /// The range of a fit that comes from `value`: the limits, and where there is none a factor of `largest_change`, but no
    /// further from the nominal value than `range_moves` moves lead; the last of them toward zero reaches it, for a term may not be
    /// there at all.
    pub(super) fn range(&self, value: f64, priors: &PriorSettings) -> Range {
        if !self.calibrated {
            return Range { min: self.min, max: self.max };
        }
        let change = priors.largest_change;
        let farthest = change.powi(priors.range_moves + 1);
        let factor = (value / self.nominal).clamp(1.0 / farthest, farthest);
        let near = if factor <= change / farthest { 0.0 } else { self.nominal * factor / change };
        let far = self.nominal * (factor * change).min(farthest);
        let (low, high) = if near < far { (near, far) } else { (far, near) };
        Range {
            min: if self.min.is_finite() { self.min } else { low.min(self.max) },
            max: if self.max.is_finite() { self.max } else { high.max(self.min) },
        }
    }

    /// The range in which a fit begins that starts from `value`: that of the nominal value, moved if it has moved before.
    pub(super) fn first_range(&self, value: f64, priors: &PriorSettings) -> Range {
        let range = self.range(self.nominal, priors);
        if range.bounded(value) == value { range } else { self.range(value, priors) }
    }

    /// Whether a value has come to the end of a range where the model file or the effect sets none.
    pub(super) fn ends_on(&self, range: Range, value: f64) -> bool {
        range.ends_at(value) && value != self.min && value != self.max
    }
}

/// Where an unknown may lie in a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub(super) min: f64,
    pub(super) max: f64,
}

impl Range {
    /// The value of the range that is nearest.
    pub(super) fn bounded(self, value: f64) -> f64 {
        value.max(self.min).min(self.max)
    }

    pub(super) fn ends_at(self, value: f64) -> bool {
        value <= self.min || value >= self.max
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
