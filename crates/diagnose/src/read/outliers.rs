//! Samples that stand alone, far from what comes before and after: readings of no motion.

use super::warning::Warning;
use crate::settings::OutlierSettings;
use bracketry_numerics::statistics::{extremes, median};
use std::ops::Range;

/// Neighbors on each side whose differences show how fast the column moves.
const NEIGHBORS: usize = 3;
/// Rounds of a search: an outlier beside another one is seen once that is gone.
const ROUNDS: usize = 5;

/// Marks as lost the samples of a column that stand alone, and says which; only says it where they are too many.
pub(super) fn drop_outliers(
    name: &str,
    times: &[f64],
    values: &mut [f64],
    inputs: &[&[f64]],
    noise: f64,
    settings: &OutlierSettings,
) -> Option<Warning> {
    let found = outliers(times, values, inputs, noise, settings);
    let samples = values.iter().filter(|v| v.is_finite()).count();
    let left_out = found.len() as f64 <= settings.most * samples as f64;
    let at = found.iter().take(settings.listed).map(|&k| times[k]).collect();
    if left_out {
        for &k in &found {
            values[k] = f64::NAN;
        }
    }
    let warning = Warning::Outliers { name: name.to_owned(), count: found.len(), samples, at, left_out };
    (!found.is_empty()).then_some(warning)
}

/// Places of the samples of a column, NaN where lost, that differ from both neighbors in the same direction by far more than noise of the
/// standard deviation `noise`, and than the samples around them differ from each other. A step is none, nor the tip of a triangle, nor a
/// peak of several samples. Where there are such samples, the same is true of the first and the last one, and of two in a row: that they
/// are far from what is measured happens to any sample.
///
/// An impulse of an input may be followed by one of the motion: where samples that stand alone are found mainly where inputs jump, those
/// there are motion.
fn outliers(times: &[f64], values: &[f64], inputs: &[&[f64]], noise: f64, settings: &OutlierSettings) -> Vec<usize> {
    let known: Vec<usize> = (0..values.len()).filter(|&k| values[k].is_finite()).collect();
    let least = settings.beyond_noise * noise.max(smallest_step(values) / 12f64.sqrt());
    let step = median(known.windows(2).map(|w| times[w[1]] - times[w[0]]).collect()).unwrap_or(0.0);
    let mut rest = Rest { times, values, known, least, longest: 4.0 * NEIGHBORS as f64 * step, settings };
    let mut found = rest.take_out(1, false);
    let others = Rest { known: rest.known.clone(), ..rest }.take_out(2, true);
    if others.len() <= 2 * found.len() {
        found.extend(others);
    }
    if found.is_empty() {
        return found;
    }
    found.sort_unstable();
    without_answers(found, &jumps(inputs, values.len(), settings))
}

/// What has not been taken out of a column.
struct Rest<'a> {
    times: &'a [f64],
    values: &'a [f64],
    /// Places of the samples.
    known: Vec<usize>,
    /// Heights below it are noise.
    least: f64,
    /// Longest time from the first to the last sample that are compared, s.
    longest: f64,
    settings: &'a OutlierSettings,
}

impl Rest<'_> {
    /// Takes out runs of at most `width` samples that stand alone, at the `ends` of the column, too. The places of their samples.
    fn take_out(&mut self, width: usize, ends: bool) -> Vec<usize> {
        let mut found = Vec::new();
        for _ in 0..ROUNDS {
            let single: Vec<f64> = (0..self.known.len()).map(|i| self.height(i..i + 1, false)).collect();
            let runs = (0..self.known.len()).flat_map(|i| (1..=width).map(move |w| i..i + w));
            let alone = runs.filter(|run| self.is_alone(run.clone(), &single, ends));
            let mut out: Vec<usize> = alone.flatten().map(|i| self.known[i]).collect();
            out.dedup();
            if out.is_empty() {
                break;
            }
            self.known.retain(|k| out.binary_search(k).is_err());
            found.extend(out);
        }
        found
    }

    fn is_alone(&self, run: Range<usize>, single: &[f64], ends: bool) -> bool {
        let height = self.height(run.clone(), ends);
        if height <= self.least {
            return false;
        }
        let around = run.start.saturating_sub(NEIGHBORS)..(run.end + NEIGHBORS).min(self.known.len());
        let time = self.times[self.known[around.end - 1]] - self.times[self.known[around.start]];
        // Other outliers do not count as motion.
        let low = self.least.max(height / self.settings.beyond_motion);
        let quiet: Vec<usize> = around.clone().filter(|j| !run.contains(j) && single[*j] <= low).collect();
        time < self.longest
            && quiet.len() >= NEIGHBORS
            && self.is_farthest(run, around)
            && height > self.settings.beyond_motion * self.motion(&quiet)
    }

    fn value(&self, i: usize) -> f64 {
        self.values[self.known[i]]
    }

    /// By how much the samples of a run are above, or below, those before and after it; 0 if they are not. At the `ends` of the column, one
    /// of these is enough.
    fn height(&self, run: Range<usize>, ends: bool) -> f64 {
        let before = run.start.checked_sub(1);
        let after = (run.end < self.known.len()).then_some(run.end);
        if run.end > self.known.len() || !ends && (before.is_none() || after.is_none()) {
            return 0.0;
        }
        let neighbors = || before.into_iter().chain(after);
        let (low, high) = extremes(run.flat_map(|i| neighbors().map(move |j| self.value(i) - self.value(j))));
        if low > 0.0 { low } else { (-high).max(0.0) }
    }

    /// Whether no sample around a run is farther from their median: what lies between two outliers is far from both neighbors, too.
    fn is_farthest(&self, run: Range<usize>, around: Range<usize>) -> bool {
        let Some(middle) = median(around.clone().map(|j| self.value(j)).collect()) else { return false };
        let distance = |j: usize| (self.value(j) - middle).abs();
        let (_, own) = extremes(run.map(distance));
        around.map(distance).all(|d| d <= own)
    }

    /// The largest difference of neighbors among samples, per sample between them.
    fn motion(&self, among: &[usize]) -> f64 {
        let slope = |w: &[usize]| (self.value(w[1]) - self.value(w[0])).abs() / (w[1] - w[0]) as f64;
        among.windows(2).map(slope).fold(0.0, f64::max)
    }
}

/// The smallest distance of two different values: of a coarse column, its resolution.
fn smallest_step(values: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let steps = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0);
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Where an input has changed shortly before by far more than it does around.
fn jumps(inputs: &[&[f64]], count: usize, settings: &OutlierSettings) -> Vec<bool> {
    let mut near = vec![false; count];
    for input in inputs {
        let steps: Vec<f64> = input.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
        for k in 0..steps.len() {
            let around = (k.saturating_sub(2 * NEIGHBORS)..k.saturating_sub(1))
                .chain(k + 2..(k + 2 * NEIGHBORS).min(steps.len()))
                .map(|j| steps[j]);
            if steps[k] > settings.beyond_motion * around.fold(0.0, f64::max) {
                near[k..(k + NEIGHBORS).min(count)].iter_mut().for_each(|n| *n = true);
            }
        }
    }
    near
}

/// Leaves out those near jumps of inputs where they are more than twice as frequent there as elsewhere.
fn without_answers(found: Vec<usize>, near: &[bool]) -> Vec<usize> {
    let time = near.iter().filter(|n| **n).count() as f64 / near.len().max(1) as f64;
    let there = found.iter().filter(|k| near[**k]).count() as f64;
    if there > 2.0 * time * found.len() as f64 { found.into_iter().filter(|k| !near[*k]).collect() } else { found }
}
