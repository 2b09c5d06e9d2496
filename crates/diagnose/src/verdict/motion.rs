//! Whether data hold any motion.

use crate::{Measured, Record};

/// A column holds motion if nine tenths of its values spread more than this many times as far as its noise alone would.
const STANDS_OUT: f64 = 1.5;
/// Nine tenths of a normal variable lie within this many standard deviations around its mean, to both sides.
const NINE_TENTHS: f64 = 1.645;

/// Measured columns that stand out of their noise in no record, by name, and whether those are all. Single outliers are no motion.
pub(super) fn still(records: &[Record]) -> (Vec<String>, bool) {
    let moves = |m: &Measured| spread(&m.values) > STANDS_OUT * 2.0 * NINE_TENTHS * m.noise;
    let mut names: Vec<&str> = Vec::new();
    for m in records.iter().flat_map(|r| &r.measured) {
        if !names.contains(&m.name.as_str()) {
            names.push(&m.name);
        }
    }
    let all = names.len();
    names.retain(|name| !records.iter().flat_map(|r| &r.measured).any(|m| m.name == *name && moves(m)));
    (names.iter().map(|&n| n.to_owned()).collect(), names.len() == all)
}

/// Distance between the 5th and the 95th percentile of the values that are there.
fn spread(values: &[f64]) -> f64 {
    let mut known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    known.sort_by(f64::total_cmp);
    let at = |share: f64| known.get((share * known.len().saturating_sub(1) as f64).round() as usize).copied();
    at(0.95).zip(at(0.05)).map_or(0.0, |(high, low)| high - low)
}
