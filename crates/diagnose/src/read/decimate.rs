//! Rows of long runs between which nothing happens but noise.

use bracketry_sim::Hold;

use super::warning::Warning;
use crate::record::Record;
use crate::settings::DecimationSettings;
use crate::signal::{Measured, Signal};
use crate::study::stretches;

/// Leaves every k-th row of a long run, with the means of the inputs, where the measurements between are on straight lines within their
/// noise: the largest such k that leaves no fewer rows than the settings say. Nothing if the run is short or moves too fast.
pub(super) fn decimate(record: &mut Record, settings: &DecimationSettings) -> Option<Warning> {
    let rows = record.times.len();
    let most = rows / settings.rows.max(1);
    let every = (2..=most).rev().find(|&k| is_straight(record, k, settings))?;
    let groups: Vec<(usize, usize)> = stretches(record)
        .into_iter()
        .flat_map(|(from, to)| (from..to).step_by(every).map(move |k| (k, (k + every).min(to))))
        .collect();
    let starts: Vec<usize> = record.gaps.iter().map(|gap| groups.partition_point(|(first, _)| first < gap)).collect();
    let thinned = |signal: &Signal| {
        let value = |&(from, to): &(usize, usize)| mean(record, signal, from, to, every);
        Signal { values: groups.iter().map(value).collect(), hold: signal.hold }
    };
    let kept = |values: &[f64]| groups.iter().map(|group| values[group.0]).collect::<Vec<f64>>();
    *record = Record {
        name: record.name.clone(),
        times: kept(&record.times),
        inputs: record.inputs.iter().map(thinned).collect(),
        input_derivatives: record.input_derivatives.iter().map(thinned).collect(),
        measured: record.measured.iter().map(|m| Measured { values: kept(&m.values), ..m.clone() }).collect(),
        gaps: starts,
        audit: record.audit.take(),
    };
    Some(Warning::Decimated { rows, every })
}

/// What acts from a row until the next one that is kept: of a held input the mean over that time, of one that follows straight lines the
/// mean about the row.
fn mean(record: &Record, signal: &Signal, from: usize, to: usize, every: usize) -> f64 {
    let average = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    match signal.hold {
        Hold::Previous => {
            let times = &record.times;
            let next = |k: usize| times.get(k + 1).copied().filter(|_| k + 1 < to || to == from + every);
            let weights: Vec<f64> = (from..to).map(|k| next(k).map_or(0.0, |t| t - times[k])).collect();
            let total: f64 = weights.iter().sum();
            if total > 0.0 {
                signal.values[from..to].iter().zip(&weights).map(|(v, w)| v * w).sum::<f64>() / total
            } else {
                average(&signal.values[from..to])
            }
        }
        Hold::Linear => {
            let half = (every / 2).min(from).min(signal.values.len() - 1 - from);
            average(&signal.values[from - half..=from + half])
        }
    }
}

/// Whether the rows between every k-th one are on straight lines, within the noise and a share of the column's spread.
fn is_straight(record: &Record, every: usize, settings: &DecimationSettings) -> bool {
    let stretches = stretches(record);
    record.measured.iter().all(|m| {
        let (mut square, mut count) = (0.0, 0.0);
        for &(from, to) in &stretches {
            for first in (from..to.saturating_sub(every)).step_by(every) {
                let (a, b) = (m.values[first], m.values[first + every]);
                let (start, length) = (record.times[first], record.times[first + every] - record.times[first]);
                for k in first + 1..first + every {
                    let share = (record.times[k] - start) / length;
                    let off = m.values[k] - a - share * (b - a);
                    // Of noise alone the expected square, by the share.
                    let noise = 1.0 + share * share + (1.0 - share) * (1.0 - share);
                    if off.is_finite() {
                        square += off * off / noise;
                        count += 1.0;
                    }
                }
            }
        }
        let off = (square / f64::max(count, 1.0)).sqrt();
        off <= (settings.beyond_noise * m.noise).max(settings.share_of_spread * m.variance().sqrt())
    })
}
