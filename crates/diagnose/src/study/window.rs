//! Windows: disjoint stretches of a record, each with an initial state of its own.

use crate::record::Record;

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
