//! What lies between a true value and what a measured column shows of it.

use super::signal_path::lagged;
use crate::effect::Path;
use bracketry_numerics::statistics::rms;
use bracketry_sim::Hold;

/// The path of a measured column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ColumnPath {
    pub(super) delay: f64,
    /// Time constant of a first-order filter.
    pub(super) lag: f64,
    /// That of one which is computed from sample to sample.
    pub(super) digital: f64,
    pub(super) offset: f64,
    /// Growth of the offset per second from the start of the record.
    pub(super) drift: f64,
}

impl ColumnPath {
    /// Adds what an effect with this value does.
    pub(super) fn add(&mut self, path: Path, value: f64) {
        match path {
            Path::SensorBias => self.offset += value,
            Path::SensorDrift => self.drift += value,
            Path::SensorLag => self.lag += value,
            Path::DigitalFilter => self.digital += value,
            Path::SensorDelay | Path::InputDelay | Path::ActuatorLag => self.delay += value,
        }
    }

    /// The filter, if there is one. Two in a row count as one.
    pub(super) fn filter(&self) -> Option<Filter> {
        let lag = self.lag + self.digital;
        (lag > 0.0).then_some(Filter { lag, digital: self.digital > self.lag })
    }

    /// What is added to the true value this long after the start of the record.
    pub(super) fn offset_after(&self, elapsed: f64) -> f64 {
        self.offset + self.drift * elapsed
    }
}

/// A filter begins behind its values by at most this many of their changes, root mean square, during its time constant.
const MOST_BEHIND: f64 = 3.0;

/// Root mean square of the slope; 0 where it is no number.
fn slope(times: &[f64], values: &[f64]) -> f64 {
    let rates = times.windows(2).zip(values.windows(2)).map(|(t, v)| (v[1] - v[0]) / (t[1] - t[0]));
    let slope = rms(rates);
    if slope.is_finite() { slope } else { 0.0 }
}

/// A first-order filter.
#[derive(Clone, Copy)]
pub(super) struct Filter {
    /// Time constant, s.
    pub(super) lag: f64,
    /// Whether it is computed from sample to sample: y_k = y_{k−1} + (1 − e^(−Δt/τ)) (x_k − y_{k−1}).
    digital: bool,
}

impl Filter {
    /// What it shows of values at these times if it shows the first of them at first.
    pub(super) fn applied(self, times: &[f64], values: &[f64]) -> Vec<f64> {
        if !self.digital {
            return lagged(times, values, Hold::Linear, self.lag, values[0]);
        }
        let mut shown = values[0];
        let first = std::iter::once(shown);
        let rest = times.windows(2).zip(&values[1..]).map(|(t, value)| {
            shown += (1.0 - ((t[0] - t[1]) / self.lag).exp()) * (value - shown);
            shown
        });
        first.chain(rest).collect()
    }

    /// The most by which it begins behind these values: by what moves during its time constant.
    pub(super) fn most_behind(self, times: &[f64], values: &[f64]) -> f64 {
        MOST_BEHIND * self.lag * slope(times, values)
    }
}
