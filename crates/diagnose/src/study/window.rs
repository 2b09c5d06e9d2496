//! Windows: disjoint stretches of a record, each with an initial state of its own.

use crate::record::Record;
use crate::settings::WindowSettings;
use serde::Serialize;

/// A stretch of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Index of the record.
    pub record: usize,
    /// First sample.
    pub from: usize,
    /// One past the last sample.
    pub to: usize,
}

/// Stretches of a record without a gap in time: first sample and one past the last.
pub(crate) fn stretches(record: &Record) -> Vec<(usize, usize)> {
    let mut starts = vec![0];
    starts.extend(record.gaps.iter().copied().filter(|&i| i > 0 && i < record.times.len()));
    let mut stretches = Vec::with_capacity(starts.len());
    for (i, &from) in starts.iter().enumerate() {
        stretches.push((from, starts.get(i + 1).copied().unwrap_or(record.times.len())));
    }
    stretches
}

/// Cuts every stretch into windows of equal length, as near to `length` seconds as whole windows allow; stretches of fewer
/// than `fewest` samples are left out.
pub(super) fn cut(records: &[Record], length: f64, fewest: usize) -> Vec<Window> {
    let mut windows = Vec::new();
    for (index, record) in records.iter().enumerate() {
        for (from, to) in stretches(record) {
            let samples = to - from;
            if samples < fewest {
                continue;
            }
            let duration = record.times[to - 1] - record.times[from];
            let most = (samples / fewest).max(1);
            let count = ((duration / length).round() as usize).clamp(1, most);
            for i in 0..count {
                windows.push(Window {
                    record: index,
                    from: from + i * samples / count,
                    to: from + (i + 1) * samples / count,
                });
            }
        }
    }
    windows
}

/// The windows of a fit, each with an initial state of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Windows {
    /// Their number.
    pub count: usize,
    /// Their median length, s.
    pub seconds: f64,
}

/// A length that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindowLength {
    /// Length, s.
    pub seconds: f64,
    /// Mean over the unknowns of the logarithm of their standard deviation over their scale; the smaller, the better.
    pub uncertainty: f64,
}

/// The stretches that hold a window: durations, s, and intervals between samples.
fn usable(records: &[Record], fewest: usize) -> impl Iterator<Item = (f64, usize)> {
    let all = records.iter().flat_map(|r| stretches(r).into_iter().map(move |(from, to)| (r, from, to)));
    all.filter(move |(_, from, to)| to - from >= fewest)
        .map(|(r, from, to)| (r.times[to - 1] - r.times[from], to - from - 1))
}

/// The length that leaves the fewest windows, s.
pub(super) fn longest_window(records: &[Record], settings: &WindowSettings) -> f64 {
    let usable = || usable(records, settings.fewest_samples);
    let total: f64 = usable().map(|(duration, _)| duration).sum();
    let stretch = usable().map(|(duration, _)| duration).fold(0.0, f64::max);
    (total / settings.fewest_windows).min(stretch).max(f64::MIN_POSITIVE)
}

/// The shortest window, s: of the fewest samples, and of ten per state.
pub(super) fn shortest_window(records: &[Record], states: usize, settings: &WindowSettings) -> f64 {
    let fewest = settings.fewest_samples;
    let (total, intervals) =
        usable(records, fewest).fold((0.0, 0), |(t, n), (duration, steps)| (t + duration, n + steps));
    fewest.max(10 * states) as f64 * total / f64::max(intervals as f64, 1.0)
}

/// Shares of the longest window that are windows, s.
pub(crate) fn shorter_windows(
    records: &[Record],
    states: usize,
    shares: &[f64],
    settings: &WindowSettings,
) -> Vec<f64> {
    let (longest, shortest) = (longest_window(records, settings), shortest_window(records, states, settings));
    shares.iter().map(|share| share * longest).filter(|seconds| *seconds >= shortest).collect()
}
