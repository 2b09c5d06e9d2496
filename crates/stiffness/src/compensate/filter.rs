//! Low-pass filter of wrenches.

use super::settings::CompensationError;
use crate::frame::Wrench;
use std::f64::consts::{PI, SQRT_2};

/// Order of a low-pass filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FilterOrder {
    /// One pole.
    #[default]
    First,
    /// Butterworth, two poles.
    Second,
}

/// A low-pass filter in discrete time: Butterworth by the bilinear transform, its cutoff kept, transposed direct form II.
#[derive(Clone, Debug, PartialEq)]
pub struct WrenchFilter {
    forward: [f64; 3],
    back: [f64; 2],
    memory: [Wrench; 2],
}

impl WrenchFilter {
    /// A filter whose gain has fallen to 1/√2 at `cutoff` (Hz), called once per `period` (s).
    ///
    /// # Errors
    /// [`CompensationError::Cutoff`] for a cutoff that is not between 0 and half the sampling rate.
    pub fn new(order: FilterOrder, cutoff: f64, period: f64) -> Result<Self, CompensationError> {
        // Comparisons are written so that what is no number is refused.
        if !(period > 0.0 && period.is_finite() && cutoff > 0.0 && cutoff * period < 0.5) {
            return Err(CompensationError::Cutoff { cutoff, period });
        }
        let k = (PI * cutoff * period).tan();
        let (forward, back) = match order {
            FilterOrder::First => {
                let scale = 1.0 / (1.0 + k);
                ([k * scale, k * scale, 0.0], [(k - 1.0) * scale, 0.0])
            }
            FilterOrder::Second => {
                let scale = 1.0 / (1.0 + SQRT_2 * k + k * k);
                let b = k * k * scale;
                ([b, 2.0 * b, b], [2.0 * (k * k - 1.0) * scale, (1.0 - SQRT_2 * k + k * k) * scale])
            }
        };
        Ok(Self { forward, back, memory: [Wrench::zeros(); 2] })
    }

    /// The filtered value for the next one. Starts from rest at zero.
    pub fn step(&mut self, x: &Wrench) -> Wrench {
        let [b0, b1, b2] = self.forward;
        let [a1, a2] = self.back;
        let y = x * b0 + self.memory[0];
        self.memory[0] = x * b1 - y * a1 + self.memory[1];
        self.memory[1] = x * b2 - y * a2;
        y
    }
}
