//! Statistics of samples. Values that are not numbers count as larger than all others.

/// The value of the nearest rank: that of the sorted values below which a `share` between 0 and 1 of the others lie, the upper one
/// between two; `None` without values.
///
/// ```
/// use bracketry_numerics::statistics::quantile;
/// assert_eq!(quantile(vec![3.0, 1.0, 2.0, 4.0], 0.5), Some(3.0));
/// assert_eq!(quantile(vec![3.0, 1.0, 2.0], 0.0), Some(1.0));
/// ```
pub fn quantile(mut values: Vec<f64>, share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let rank = (last as f64 * share).round() as usize;
    Some(*values.select_nth_unstable_by(rank, f64::total_cmp).1)
}

/// The median, the upper one of two; `None` without values.
pub fn median(values: Vec<f64>) -> Option<f64> {
    quantile(values, 0.5)
}

/// The smallest and the largest of the values; (∞, −∞) without any.
pub fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (v.min(low), v.max(high)))
}

/// Root mean square of the finite values; 0 without any.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.filter(|v| v.is_finite()).fold((0.0, 0usize), |(sum, n), v| (sum + v * v, n + 1));
    if count == 0 { 0.0 } else { f64::sqrt(sum / count as f64) }
}

/// Distances of neighboring values.
pub fn steps(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| pair[1] - pair[0]).collect()
}
