//! Multi-step prediction on data that no fit has seen.

use rayon::prelude::*;

use super::trial::Trial;
use crate::error::DiagnoseError;
use crate::record::Record;
use crate::settings::PredictionSettings;
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

/// The horizons that stretches of these lengths (seconds, after the part for the state) allow.
fn horizons(longest: f64, settings: &PredictionSettings) -> Vec<f64> {
    let standard: Vec<f64> = settings.horizons.iter().copied().filter(|h| *h < longest).collect();
    if standard.len() >= 2 {
        return standard;
    }
    let parts = settings.horizon_shares.iter().map(|s| (s * longest * 1e3).round() / 1e3);
    parts.filter(|h| *h > 0.0).collect()
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
    if longest <= 0.0 {
        return Ok((Vec::new(), Vec::new()));
    }
    let horizons = horizons(longest, settings);
    let mut found: Vec<AtHorizon> =
        horizons.iter().map(|&seconds| AtHorizon { seconds, ..AtHorizon::default() }).collect();
    // Starts as densely as the number of predictions allows, at least a tenth of the shortest horizon apart.
    let total: f64 = stretches().map(|w| (seconds(w) - window).max(0.0)).sum();
    let spacing = (total / settings.most_predictions as f64).max(0.1 * horizons.first().copied().unwrap_or(total));
    let variances: Vec<Vec<f64>> =
        records.iter().map(|r| r.measured.iter().map(|m| variance(&m.values)).collect()).collect();
    let mut drawn: Vec<Predicted> = Vec::new();
    for trial in trials {
        let list: Vec<Ahead> = trial
            .held_out
            .iter()
            .flat_map(|w| starts(&records[w.record], w, window, spacing, horizons[0], horizons[horizons.len() - 1]))
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

fn variance(values: &[f64]) -> f64 {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let n = known.len().max(1) as f64;
    let mean = known.iter().sum::<f64>() / n;
    known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
}
