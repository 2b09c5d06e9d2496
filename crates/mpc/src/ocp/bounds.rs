//! Bounds, and what a violation costs.

use crate::error::{MpcError, check_value};

/// Violation of a hard constraint, in units of its scale, that costs nothing: programs are solved to a tolerance, and at the
/// weight of hard constraints its noise would hide the objective.
pub(crate) const HARD_TOLERANCE: f64 = 1e-6;

/// What happens when a bound on a state cannot be kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Softness {
    /// A violation v costs dt·(linear·v + quadratic·v²).
    Soft {
        /// Weight of v; large enough, it makes the bound exact.
        linear: f64,
        /// Weight of v².
        quadratic: f64,
    },
    /// The bound has to be kept. When that is impossible the problem is solved with the smallest violation and the
    /// status says that it is infeasible.
    Hard,
}

/// Bounds of one state; infinite where there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower bound.
    pub min: f64,
    /// Upper bound.
    pub max: f64,
    /// What a violation costs.
    pub softness: Softness,
}

impl Bounds {
    /// No bound.
    pub const FREE: Bounds = Bounds { min: f64::NEG_INFINITY, max: f64::INFINITY, softness: Softness::Hard };

    pub(crate) fn is_free(&self) -> bool {
        self.min == f64::NEG_INFINITY && self.max == f64::INFINITY
    }

    /// Distance of `v` from the interval.
    pub(crate) fn violation(&self, v: f64) -> f64 {
        (self.min - v).max(v - self.max).max(0.0)
    }
}

pub(super) fn soft_weights(what: &str, softness: Softness) -> Result<(), MpcError> {
    if let Softness::Soft { linear, quadratic } = softness {
        weight(format!("the linear weight of {what}"), linear)?;
        weight(format!("the quadratic weight of {what}"), quadratic)?;
    }
    Ok(())
}

/// Violations and what they cost: `value` is in the unit of the constraint, `relative` is v over its scale if it is hard.
pub(super) struct Violation {
    pub(super) value: f64,
    pub(super) cost: f64,
    pub(super) relative: f64,
}

impl Softness {
    /// Weights of a violation and of its square; `factor` is dt along the horizon, `hard` the weight of hard ones.
    pub(crate) fn weights(self, factor: f64, hard: f64) -> (f64, f64) {
        match self {
            Softness::Soft { linear, quadratic } => (factor * linear, factor * quadratic),
            Softness::Hard => (hard, 0.0),
        }
    }

    pub(super) fn judge(self, v: f64, factor: f64, hard: f64, scale: f64) -> Violation {
        let (linear, quadratic) = self.weights(factor, hard / scale);
        Violation {
            value: v,
            cost: linear * v + quadratic * v * v,
            relative: if self == Softness::Hard { v / scale } else { 0.0 },
        }
    }
}

pub(super) fn positive(what: &'static str, value: f64) -> Result<(), MpcError> {
    check_value(value > 0.0 && value.is_finite(), what, value, "give a positive number")
}

pub(super) fn weight(what: impl Into<String>, value: f64) -> Result<(), MpcError> {
    check_value(value >= 0.0 && value.is_finite(), what, value, "give a number that is not negative")
}

pub(super) fn ordered(what: &'static str, index: usize, min: f64, max: f64) -> Result<(), MpcError> {
    if min <= max { Ok(()) } else { Err(MpcError::EmptyBounds { what, index, name: None, min, max }) }
}
