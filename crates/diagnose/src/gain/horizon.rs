//! Multi-step prediction on data that no fit has seen.

use rayon::prelude::*;

use super::trial::Trial;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::settings::PredictionSettings;
use crate::signal::Measured;
use crate::study::{Fit, Predictor, Study, Window};

/// Mean squared errors by model (as given, refitted, extended), in units of the columns' variance, and their number.
#[derive(Clone, Debug, Default)]
pub(super) struct AtHorizon {
    pub(super) seconds: f64,
    pub(super) sums: [f64; 3],
    /// Columns times predictions.
    pub(super) terms: usize,
    pub(super) predictions: usize,
}

/// A prediction that figures show: times, then per model what the columns would show.
#[derive(Clone, Debug)]
pub struct Predicted {
    /// Index of the record among those predicted.
    pub record: usize,
    /// First predicted sample.
    pub start: usize,
    /// As given, refitted, extended: per measured column the predicted values.
    pub columns: [Vec<Vec<f64>>; 3],
}

/// A prediction to be made: the state is estimated from the samples `from..start`, then nothing more is looked at but the inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Ahead {
    record: usize,
    from: usize,
    start: usize,
    to: usize,
}

impl Ahead {
    /// What the measured columns would show in `start..to`; `None` where the simulation failed.
    fn predicted(&self, model: &Predictor<'_>) -> Result<Option<Vec<Vec<f64>>>, DiagnoseError> {
        let Ahead { record, from, start, to } = *self;
        let Ok(x0) = model.fit_initial_state(Window { record, from, to: start })? else { return Ok(None) };
        let mut columns = model.predict(Window { record, from, to }, &x0)?;
        for column in &mut columns {
            column.drain(..start - from);
        }
        let complete = columns.iter().flatten().all(|v| v.is_finite());
        Ok(complete.then_some(columns))
    }
}

/// The horizons that stretches of these lengths allow: of the longest after the part for the state, s, windows, and samples.
fn horizons(longest: f64, window: f64, step: f64, settings: &PredictionSettings) -> Vec<f64> {
    if !settings.horizons.is_empty() {
        return settings.horizons.iter().copied().filter(|h| *h < longest).collect();
    }
    let usual = &settings.usual_horizons;
    let last = usual.iter().copied().fold(0.0, f64::max);
    let unit = if window > settings.slow_window * last { two_digits(window) / last } else { 1.0 };
    let fits = |h: &f64| *h < longest && *h >= settings.fewest_samples * step;
    let standard: Vec<f64> = usual.iter().map(|h| rounded(h * unit)).filter(fits).collect();
    if standard.len() >= 2 {
        return standard;
    }
    let parts = settings.horizon_shares.iter().map(|s| two_digits(s * longest));
    parts.filter(|h| *h > 0.0).collect()
}

/// A product without the rounding of binary fractions in its last digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.9e}").parse().unwrap_or(x)
}

/// A positive number rounded down to two significant digits.
fn two_digits(x: f64) -> f64 {
    let unit = 10f64.powi(x.log10().floor() as i32 - 1);
    // Quotients by whole numbers show no rounding where the unit is below one.
    if unit < 1.0 { (x / unit).floor() / (1.0 / unit).round() } else { (x / unit).floor() * unit }
}

/// Sets of predictions over held-out stretches.
pub(super) fn predict(
    study: &Study,
    trials: &[Trial],
    window: f64,
    settings: &PredictionSettings,
) -> Result<(Vec<AtHorizon>, Vec<Predicted>), DiagnoseError> {
    let records = study.records();
    let seconds = |w: &Window| records[w.record].times[w.to - 1] - records[w.record].times[w.from];
    let stretches = || trials.iter().flat_map(|t| &t.held_out);
    let longest = stretches().map(seconds).fold(0.0, f64::max) - window;
    let intervals: usize = stretches().map(|w| w.to - w.from - 1).sum();
    let step = stretches().map(seconds).sum::<f64>() / intervals.max(1) as f64;
    if longest <= 0.0 {
        return Ok((Vec::new(), Vec::new()));
    }
    let horizons = horizons(longest, window, step, settings);
    let Some(&shortest) = horizons.first() else { return Ok((Vec::new(), Vec::new())) };
    let mut found: Vec<AtHorizon> =
        horizons.iter().map(|&seconds| AtHorizon { seconds, ..AtHorizon::default() }).collect();
    // Starts as densely as the number of predictions allows, at least a tenth of the shortest horizon apart.
    let total: f64 = stretches().map(|w| (seconds(w) - window).max(0.0)).sum();
    let spacing = (total / settings.most_predictions as f64).max(0.1 * shortest);
    let variances: Vec<Vec<f64>> =
        records.iter().map(|r| r.measured.iter().map(Measured::variance).collect()).collect();
    let mut drawn: Vec<Predicted> = Vec::new();
    for trial in trials {
        let list: Vec<Ahead> = trial
            .held_out
            .iter()
            .flat_map(|w| starts(&records[w.record], w, window, spacing, shortest, horizons[horizons.len() - 1]))
            .collect();
        let of = |fit: &Fit| -> Result<Vec<Option<Vec<Vec<f64>>>>, DiagnoseError> {
            let model = study.predictor(fit)?;
            list.par_iter().map(|ahead| ahead.predicted(&model)).collect()
        };
        let (a, b, c) = (of(&trial.as_given)?, of(&trial.refitted)?, of(&trial.extended)?);
        for (((ahead, a), b), c) in list.iter().zip(a).zip(b).zip(c) {
            // A start counts if all models could be simulated from it.
            let (Some(a), Some(b), Some(c)) = (a, b, c) else { continue };
            let predicted = Predicted { record: ahead.record, start: ahead.start, columns: [a, b, c] };
            add(&mut found, &records[ahead.record], &variances[ahead.record], &predicted);
            drawn.push(predicted);
        }
    }
    found.retain(|h| h.predictions >= settings.fewest_predictions);
    Ok((found, drawn))
}

/// Predictions in a stretch: the state from `window` seconds, then as far as `furthest` seconds where there are samples, at
/// least `nearest`.
fn starts(record: &Record, stretch: &Window, window: f64, spacing: f64, nearest: f64, furthest: f64) -> Vec<Ahead> {
    let times = &record.times[..stretch.to];
    let last = times[stretch.to - 1];
    let index = |t: f64| times.partition_point(|s| *s < t);
    let mut list = Vec::new();
    let mut at = times[stretch.from] + window;
    while at + nearest <= last {
        let start = index(at);
        let from = index(times[start] - window).max(stretch.from);
        let to = times.partition_point(|s| *s <= times[start] + furthest + 1e-9);
        if start > from + 3 {
            list.push(Ahead { record: stretch.record, from, start, to });
        }
        at += spacing;
    }
    list
}

/// Adds a prediction's squared errors at the horizons it reaches.
fn add(found: &mut [AtHorizon], record: &Record, variances: &[f64], predicted: &Predicted) {
    let t0 = record.times[predicted.start];
    let length = predicted.columns[0].first().map_or(0, Vec::len);
    let times = &record.times[predicted.start..predicted.start + length];
    for h in found {
        let k = times.partition_point(|t| *t < t0 + h.seconds - 1e-9);
        if k >= length {
            continue;
        }
        let mut any = false;
        for (c, m) in record.measured.iter().enumerate() {
            let (y, variance) = (m.values[predicted.start + k], variances[c]);
            if !y.is_finite() || variance == 0.0 {
                continue;
            }
            any = true;
            h.terms += 1;
            for (sum, columns) in h.sums.iter_mut().zip(&predicted.columns) {
                *sum += (columns[c][k] - y).powi(2) / variance;
            }
        }
        h.predictions += usize::from(any);
    }
}
