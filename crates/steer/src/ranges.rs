//! Inputs within the ranges of the model.

use bracketry_system::System;

use crate::signals::Signals;

/// How far beyond an end of a range counts as rounding, relative to the largest value.
const ROUNDING: f64 = 1e-9;

/// Lower and upper ends per input, infinite where there is none.
#[derive(Clone, Debug)]
pub(crate) struct Ranges(Vec<[f64; 2]>);

impl Ranges {
    pub(crate) fn of(system: &System) -> Self {
        let ends = |u: &bracketry_symbolic::Symbol| {
            let range = system.input_ranges.iter().find(|r| r.input == *u);
            let low = range.and_then(|r| r.min.as_ref()).map_or(f64::NEG_INFINITY, |v| v.to_f64().value());
            let high = range.and_then(|r| r.max.as_ref()).map_or(f64::INFINITY, |v| v.to_f64().value());
            [low, high]
        };
        Ranges(system.inputs.iter().map(ends).collect())
    }

    /// The largest speed at which an input may go into a direction.
    pub(crate) fn limit(&self, input: usize, positive: bool) -> f64 {
        let [low, high] = self.0[input];
        (if positive { high } else { -low }).max(0.0)
    }

    /// The first input that leaves its range.
    pub(crate) fn left_by(&self, signals: &Signals) -> Option<usize> {
        (0..self.0.len()).find(|&j| {
            let ([low, high], slack) = (self.0[j], ROUNDING * signals.largest(j));
            signals.values.iter().any(|row| row[j] < low - slack || row[j] > high + slack)
        })
    }

    /// By which factor a motion without drift must be slowed so that all inputs stay within their ranges: below 1 where it
    /// may be faster, 0 without ranges, infinite where that does not help.
    pub(crate) fn slowdown(&self, signals: &Signals) -> f64 {
        let mut factor = 0.0f64;
        for j in 0..self.0.len() {
            let slack = ROUNDING * signals.largest(j);
            for row in &signals.values {
                if row[j].abs() > slack {
                    factor = factor.max(row[j].abs() / self.limit(j, row[j] > 0.0));
                }
            }
        }
        factor
    }

    /// An input that would have to move into a direction in which it has no room.
    pub(crate) fn one_sided(&self, signals: &Signals) -> Option<usize> {
        (0..self.0.len()).find(|&j| {
            let slack = ROUNDING * signals.largest(j);
            signals.values.iter().any(|row| row[j].abs() > slack && self.limit(j, row[j] > 0.0) == 0.0)
        })
    }

    /// The value within the range that is closest.
    pub(crate) fn clamped(&self, input: usize, value: f64) -> f64 {
        value.clamp(self.0[input][0], self.0[input][1])
    }
}
