//! The noise of a column, from the column itself.

/// What a column's noise is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation in the column's unit; positive.
    pub std: f64,
}

/// Smallest noise, as a share of the column's range: no instrument resolves more than 20 bits.
const RESOLUTION: f64 = 1.0 / (1 << 20) as f64;
/// Sixth differences of white noise have the variance (12 choose 6) σ².
const BINOMIAL: [f64; 7] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];
/// Median of the absolute value of a standard normal variable.
const MEDIAN_NORMAL: f64 = 0.674_489_750_196_081_7;

/// Standard deviation of the noise of a column in which NaN stands for lost values.
pub fn estimate_noise(_times: &[f64], values: &[f64]) -> Noise {
    let finite = values.iter().filter(|v| v.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(*v), b.max(*v)));
    let size = (high - low).max(high.abs() * RESOLUTION).max(f64::MIN_POSITIVE);
    let mut differences: Vec<f64> = values
        .windows(BINOMIAL.len())
        .map(|w| w.iter().zip(BINOMIAL).map(|(v, c)| v * c).sum::<f64>().abs())
        .filter(|d| d.is_finite())
        .collect();
    let floor = size * RESOLUTION;
    if differences.is_empty() {
        return Noise { std: floor };
    }
    let middle = differences.len() / 2;
    let (_, median, _) = differences.select_nth_unstable_by(middle, f64::total_cmp);
    Noise { std: (*median / MEDIAN_NORMAL / 924f64.sqrt()).max(floor) }
}
