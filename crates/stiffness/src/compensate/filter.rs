//! Low-pass filter of wrenches, and its prediction ahead.

use super::error::CompensationError;
use crate::robot::Wrench;
use nalgebra::Complex;
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

    /// What the filter delays slow changes by: its group delay at frequency 0 (s), `Ω = 2/T tan(π f T)` the cutoff before the bilinear
    /// transform.
    fn delay(order: FilterOrder, cutoff: f64, period: f64) -> f64 {
        let time = period / (2.0 * (PI * cutoff * period).tan());
        match order {
            FilterOrder::First => time,
            FilterOrder::Second => SQRT_2 * time,
        }
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

/// What the largest gain of filter and prediction exceeds 1 by. The bilinear transform moves frequencies and keeps gains.
pub(super) fn largest_excess(order: FilterOrder, cutoff: f64, period: f64, lag: f64) -> f64 {
    let delay = |order| WrenchFilter::delay(order, cutoff, period);
    let lead = (lag + delay(order)) / delay(FilterOrder::First);
    let gain = |x: f64| {
        let pole = Complex::new(1.0, x).inv();
        let filter = match order {
            FilterOrder::First => pole,
            FilterOrder::Second => Complex::new(1.0 - x * x, SQRT_2 * x).inv(),
        };
        (filter * (1.0 + (1.0 - pole) * lead)).norm()
    };
    // Three decades about the cutoff.
    (0..=300).map(|k| gain(10f64.powf(-1.5 + 0.01 * f64::from(k)))).fold(1.0, f64::max) - 1.0
}

/// A filtered wrench as it will be when a correction acts: `y + T ẏ`, the derivative `ẏ` through one more pole at the cutoff, `T` the delay of
/// the filter and the lag of the servo together. Slow changes come out undelayed; near the cutoff the gain rises above one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Prediction {
    /// One pole at the cutoff: `s/(1 + s/Ω) = Ω (1 − 1/(1 + s/Ω))`.
    pole: WrenchFilter,
    /// `T Ω`.
    lead: f64,
}

impl Prediction {
    /// Of a filter whose input acts on the robot `lag` (s) before the correction does.
    pub(super) fn new(order: FilterOrder, cutoff: f64, period: f64, lag: f64) -> Result<Self, CompensationError> {
        if !(lag >= 0.0 && lag.is_finite()) {
            return Err(CompensationError::Lag { lag });
        }
        let pole = WrenchFilter::new(FilterOrder::First, cutoff, period)?;
        let ahead = lag + WrenchFilter::delay(order, cutoff, period);
        Ok(Self { pole, lead: ahead / WrenchFilter::delay(FilterOrder::First, cutoff, period) })
    }

    /// The prediction from the next filtered value.
    pub(super) fn step(&mut self, filtered: &Wrench) -> Wrench {
        filtered + (filtered - self.pole.step(filtered)) * self.lead
    }
}
