//! Statistics of trials.

use serde::{Deserialize, Serialize};

/// Standard normal quantile of a two-sided 95 % interval.
const Z95: f64 = 1.959_963_984_540_054;

/// A share with its 95 % confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// How many.
    pub count: usize,
    /// Of how many.
    pub of: usize,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Share {
    /// `count` of `of` with the score interval of Wilson (1927), which holds for small numbers and shares near 1 too. Of none,
    /// the interval is from 0 to 1.
    ///
    /// ```
    /// let share = bracketry_trials::Share::new(95, 100);
    /// assert!((share.low - 0.888249).abs() < 1e-6 && (share.high - 0.978456).abs() < 1e-6);
    /// ```
    pub fn new(count: usize, of: usize) -> Self {
        if of == 0 {
            return Self { count, of, low: 0.0, high: 1.0 };
        }
        let (n, p, z2) = (of as f64, count as f64 / of as f64, Z95 * Z95);
        let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = Z95 / (1.0 + z2 / n) * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
        Self { count, of, low: (middle - half).max(0.0), high: (middle + half).min(1.0) }
    }

    /// The share; NaN of none.
    pub fn value(&self) -> f64 {
        self.count as f64 / self.of as f64
    }
}

/// The quantile `q` in [0, 1] by linear interpolation between order statistics (type 7 of Hyndman and Fan 1996); absent for no
/// values and where it is infinite. Values need no order; infinite ones stand for what never happened.
///
/// ```
/// use bracketry_trials::quantile;
/// assert_eq!(quantile(&[3.0, 1.0, 2.0, 4.0], 0.5), Some(2.5));
/// assert_eq!(quantile(&[1.0, f64::INFINITY, f64::INFINITY], 0.5), None);
/// ```
pub fn quantile(values: &[f64], q: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = q.clamp(0.0, 1.0) * sorted.len().checked_sub(1)? as f64;
    let (below, share) = (place.floor() as usize, place.fract());
    let (low, high) = (sorted[below], sorted[(below + 1).min(sorted.len() - 1)]);
    let value = if share == 0.0 { low } else { low + share * (high - low) };
    value.is_finite().then_some(value)
}

/// Quantiles of a quantity, absent where it is infinite.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// 5 %.
    pub p5: Option<f64>,
    /// 25 %.
    pub p25: Option<f64>,
    /// Median.
    pub p50: Option<f64>,
    /// 75 %.
    pub p75: Option<f64>,
    /// 95 %.
    pub p95: Option<f64>,
    /// 99 %.
    pub p99: Option<f64>,
    /// The greatest.
    pub max: Option<f64>,
}

impl Quantiles {
    /// The quantiles of values; see [`quantile`].
    pub fn of(values: &[f64]) -> Self {
        let [p5, p25, p50, p75, p95, p99, max] = [0.05, 0.25, 0.5, 0.75, 0.95, 0.99, 1.0].map(|q| quantile(values, q));
        Self { p5, p25, p50, p75, p95, p99, max }
    }
}
