//! How a unit vector's σ reaches zero, which it does without a change of sign.
//!
//! A step is never longer than most of the time in which `|σ|` would reach zero at its present rate, so that `|σ|` shrinks
//! geometrically. What falls below the resolution of the tolerance while it shrinks has arrived: the rest of the way
//! is a step in a fixed direction.

use crate::events::NEGLIGIBLE;
use crate::multipliers::norm;
use crate::stepper::Stepper;
use crate::trajectory::Trajectory;
use crate::{Mode, StopReason, Switched};

/// Part of the time to zero that a step may use.
const SHARE: f64 = 0.9;
/// Size of σ, in units of the absolute tolerance, below which a direction has no meaning.
const ARRIVAL: f64 = 10.0;

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

impl<S: Switched> Stepper<S> {
    /// Rounding to expect in the σ of a switch at the current point, by the gradients of the last point.
    pub(crate) fn rounding(&self, switch: usize) -> f64 {
        let part = self.multipliers.parts[switch].clone();
        part.map(|c| self.multipliers.noise(c, &self.x, &self.k[0], 0.0)).fold(0.0, f64::max)
    }

    /// How far the σ of a switch moves when every state moves by `size`.
    fn reach(&self, switch: usize, size: f64) -> f64 {
        self.multipliers.parts[switch].clone().map(|c| self.multipliers.spread(c, size)).fold(0.0, f64::max)
    }

    /// Size of σ that is rounding.
    pub(crate) fn negligible(&self, switch: usize) -> f64 {
        self.rounding(switch) + self.reach(switch, NEGLIGIBLE * self.settings.atol)
    }

    /// Size of σ below which a unit vector that shrinks has arrived.
    pub(crate) fn arrival_size(&self, switch: usize) -> f64 {
        4.0 * self.rounding(switch) + self.reach(switch, ARRIVAL * self.settings.atol)
    }

    /// How the sliding unit vectors approach zero from the current point, whose first stage is known.
    pub(crate) fn approach(&mut self, remaining: f64) -> Approach {
        let slides = |i: &usize| self.modes[*i] == Mode::Sliding && !self.departing[*i];
        let sliding: Vec<usize> = (0..self.modes.len()).filter(slides).collect();
        let before = std::mem::replace(&mut self.nearest, f64::INFINITY);
        if sliding.is_empty() {
            return Approach::None;
        }
        self.system.switching(self.t, &self.x, &mut self.sigma);
        self.multipliers.gradients(&mut self.system, self.t, &self.x);
        self.multipliers.s.copy_from_slice(&self.signs[0]);
        let mut longest = f64::INFINITY;
        for i in sliding {
            let rate = self.multipliers.radial_rate(i, &self.k[0]);
            let size = norm(&self.sigma[self.multipliers.parts[i].clone()]);
            self.nearest = self.nearest.min(size);
            if rate >= 0.0 {
                continue;
            }
            let after = -size / rate;
            if (size <= self.arrival_size(i) || after <= 100.0 * self.shortest()) && after < remaining {
                return Approach::Arrives { switch: i, after };
            }
            longest = longest.min((SHARE * after).max(10.0 * self.shortest()));
        }
        if self.nearest < before && before.is_finite() && !self.implicit {
            // The direction turns at a rate that grows like 1/|σ|.
            self.h *= self.nearest / before;
        }
        if longest.is_finite() { Approach::Within(longest) } else { Approach::None }
    }

    /// The last step of a unit vector to zero, in its present direction, and what follows.
    pub(crate) fn arrive(
        &mut self,
        switch: usize,
        after: f64,
        trajectory: &mut Option<&mut Trajectory>,
    ) -> Result<(), StopReason> {
        if after > self.shortest() {
            for i in 0..self.modes.len() {
                if self.modes[i] == Mode::Sliding {
                    let size = norm(&self.sigma[self.multipliers.parts[i].clone()]);
                    self.multipliers.held[i] = size <= self.arrival_size(i);
                }
            }
            self.implicit = false;
            let solved = self.attempt_to_event(after);
            self.multipliers.held.fill(false);
            if !solved {
                return Err(StopReason::NonFinite);
            }
            self.accept(after, trajectory);
        }
        self.gather(switch, false);
        self.count_event()?;
        let before = self.modes.clone();
        let jump = self.before_jump(switch);
        self.settle(&before, trajectory)?;
        self.record_jump(jump);
        Ok(())
    }
}
