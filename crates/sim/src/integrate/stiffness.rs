//! How a unit vector's σ reaches zero, which it does without a change of sign, and how stiff that is.
//!
//! A step is never longer than most of the time in which `|σ|` would reach zero at its present rate, so that `|σ|` shrinks
//! geometrically. What falls below the resolution of the tolerance while it shrinks has arrived: the last step has a fixed
//! direction.

use super::step::{Method, Step};
use crate::friction::{Field, FrictionMode};

/// Part of the time to zero that a step may use.
const SHARE: f64 = 0.9;
/// Explicit steps are stable to 3.3 times `|σ|/|∂σ̇/∂s|`.
const STIFF: f64 = 2.0;
/// Steps for which a measured influence is trusted.
const TRUSTED: usize = 16;

/// What the nearest of the sliding unit vectors does.
pub(crate) enum Approach {
    /// None comes near zero.
    None,
    /// Steps may have this length.
    Within(f64),
    /// `switch` reaches zero in `after` seconds, which is nothing.
    Arrives {
        /// The switch.
        switch: usize,
        /// Seconds to go.
        after: f64,
    },
}

/// What is known of the sliding unit vectors at the present point.
#[derive(Debug, Clone)]
pub(crate) struct Stiffness {
    /// Least `|σ|`.
    nearest: f64,
    /// Influence of the directions on their own σ̇, and the step at which it was measured.
    influence: f64,
    measured: Option<usize>,
}

impl Stiffness {
    pub(crate) fn new() -> Self {
        Self { nearest: f64::INFINITY, influence: 0.0, measured: None }
    }

    /// Forgets the influence, as where the modes change.
    pub(crate) fn forget(&mut self) {
        self.measured = None;
    }

    /// How the unit vectors approach zero from the start of a step, whose first stage is known. `length`, which was to be tried
    /// next, shrinks as the nearest comes nearer.
    pub(crate) fn approach(
        &mut self,
        field: &mut Field<'_>,
        step: &Step,
        (remaining, atol): (f64, f64),
        length: &mut f64,
    ) -> Approach {
        let before = std::mem::replace(&mut self.nearest, f64::INFINITY);
        let sliding: Vec<usize> = field.in_mode(FrictionMode::Sliding).filter(|&i| !field.departing[i]).collect();
        if sliding.is_empty() {
            return Approach::None;
        }
        field.surfaces.evaluate(&mut field.system, step.t, &step.x);
        field.surfaces.differentiate(&mut field.system, step.t, &step.x);
        field.s.copy_from_slice(&step.signs[0]);
        let mut longest = f64::INFINITY;
        for i in sliding {
            let rate = field.radial_rate(i, &step.k[0]);
            let size = field.surfaces.size(i);
            self.nearest = self.nearest.min(size);
            if rate >= 0.0 {
                continue;
            }
            let after = -size / rate;
            let arrived = size <= field.surfaces.arrival_size(i, &step.x, atol) || after <= 100.0 * step.shortest();
            if arrived && after < remaining {
                return Approach::Arrives { switch: i, after };
            }
            longest = longest.min((SHARE * after).max(10.0 * step.shortest()));
        }
        if self.nearest < before && before.is_finite() && step.method != Method::Directions {
            // The direction turns at a rate that grows like 1/|σ|.
            *length *= self.nearest / before;
        }
        if longest.is_finite() { Approach::Within(longest) } else { Approach::None }
    }

    /// Whether a step of length `h` from the present point, after `attempts` of others, has to solve for the directions.
    pub(crate) fn is_stiff(&mut self, field: &mut Field<'_>, step: &Step, h: f64, attempts: usize) -> bool {
        if field.in_mode(FrictionMode::Sliding).any(|i| field.departing[i]) {
            return true;
        }
        if self.nearest.is_infinite() {
            return false;
        }
        if self.measured.is_none_or(|at| attempts > at + TRUSTED) {
            let influence = field.influence_of_directions((step.t, &step.x), &step.signs[0]);
            self.influence = influence.map_or(0.0, |m| m.amax());
            self.measured = Some(attempts);
        }
        let limit = if step.method == Method::Directions { 0.5 * STIFF } else { STIFF };
        h * self.influence > limit * self.nearest
    }
}
