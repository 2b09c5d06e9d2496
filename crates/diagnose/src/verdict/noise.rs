//! How sure a difference of sums of squares is.

use super::alarm::{Alarm, upper_tail};
use super::score::Scores;

/// The scatter by which differences of sums of squares are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scatter {
    /// Variance of the residual, in units of the estimated noise's variance.
    pub(crate) variance: f64,
    /// Factor by which correlation within windows widens what the residual can feign: 1 for white residuals.
    pub(crate) inflation: f64,
    /// Degrees of freedom of `variance × inflation`.
    pub(crate) freedom: f64,
    /// Samples.
    pub(crate) samples: f64,
}

impl Scatter {
    /// Of a residual that is taken as white.
    pub(crate) fn of(alarm: &Alarm) -> Self {
        Self { variance: alarm.square / alarm.freedom, inflation: 1.0, freedom: alarm.freedom, samples: alarm.freedom }
    }

    /// Of the residual of the best explanation so far, by the linearized problem around it.
    pub(crate) fn linearized(alarm: &Alarm, scores: &Scores) -> Self {
        let variance = alarm.square / alarm.freedom;
        let (inflation, independent) = scores.inflation(variance);
        let windows = scores.window_count() as f64;
        Self {
            variance,
            inflation: inflation.max(1.0),
            freedom: ((windows - 1.0) * independent).clamp(1.0, alarm.freedom),
            samples: alarm.freedom,
        }
    }

    /// Decrease of the sum of squares that a useless coefficient brings on average.
    pub(crate) fn unit(&self) -> f64 {
        self.variance * self.inflation
    }

    /// Factor by which the same correlation widens standard deviations that were computed for white residuals.
    pub(crate) fn width(&self) -> f64 {
        self.inflation.sqrt()
    }

    /// Probability that `coefficients` useless coefficients gain at least `square` (Fisher's F).
    pub(crate) fn p_value(&self, square: f64, coefficients: usize) -> f64 {
        let k = coefficients.max(1) as f64;
        upper_tail(square / (k * self.unit()), k, self.freedom)
    }

    /// Price of a coefficient: the logarithm of the number of independent samples (Schwarz 1978).
    pub(crate) fn price(&self) -> f64 {
        (self.samples / self.inflation).max(std::f64::consts::E).ln()
    }

    /// Schwarz's criterion, up to a constant: smaller is better.
    pub(crate) fn criterion(&self, square: f64, coefficients: usize) -> f64 {
        square / self.unit() + self.price() * coefficients as f64
    }
}
