//! The noise of a column, from the column itself.

use crate::settings::NoiseSettings;
use bracketry_numerics::statistics::{extremes, steps};

/// Orders of differences, from the least spread to the least influenced by the motion.
const DIFFERENCE_ORDERS: [usize; 5] = [3, 4, 5, 6, HIGHEST_DIFFERENCE];
const HIGHEST_DIFFERENCE: usize = 8;

/// What the noise of a column is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation in the column's unit; positive.
    pub std: f64,
    /// Correlation of neighboring samples of the noise; 0 where it was not told from white noise.
    pub correlation: f64,
    /// Distance of neighboring values, where all values are multiples of one.
    pub resolution: Option<f64>,
}

/// The noise of a column in which NaN stands for lost values: standard deviation, correlation, resolution.
///
/// Differences of order p vanish on motion that is smooth on the scale of p samples, and leave noise of known variance
/// (Hall, Kay, and Titterington 1990; here with the weights of divided differences, for any times). The lowest order
/// is taken from which higher ones no longer lower the estimate; reversals and outliers do not count, by cutting at three standard
/// deviations. The same with every second, fourth, … sample tells correlated noise from white: of white noise the estimate stays,
/// and where it does not it is followed until it does, or until motion sets in. Noise is at least q/√12 for a resolution q,
/// and a millionth of the range.
pub fn estimate_noise(times: &[f64], values: &[f64], settings: &NoiseSettings) -> Noise {
    let (low, high) = extremes(values.iter().copied().filter(|v| v.is_finite()));
    let size = (high - low).max(high.abs() * settings.finest_resolution);
    let resolution = resolution(values, settings.fewest_differences);
    let floor =
        (size * settings.finest_resolution).max(resolution.unwrap_or(0.0) / 12f64.sqrt()).max(f64::MIN_POSITIVE);
    let floor = if floor.is_finite() { floor } else { 1.0 };
    // A sensor that is slower than the record has its own samples.
    let (times, known): (Vec<f64>, Vec<f64>) =
        times.iter().zip(values).filter(|(_, v)| v.is_finite()).map(|(t, v)| (*t, *v)).unzip();
    let column = Column::new(&times, &known, settings.fewest_differences);
    let scales: Vec<f64> = DIFFERENCE_ORDERS.iter().map_while(|order| column.scale(*order, 1)).collect();
    let lowest = |k: usize| scales[k + 1..].iter().copied().fold(f64::INFINITY, f64::min);
    let Some(white) = (0..scales.len()).find(|k| scales[*k] <= settings.same_scale * lowest(*k)).map(|k| scales[k])
    else {
        return Noise { std: floor, correlation: 0.0, resolution };
    };
    // Beyond the statistical error of the ratio of two scales.
    let tolerance = 1.05 + 4.0 / (known.len() as f64).sqrt();
    let (mut std, mut distance, mut correlation) = (white, 1, 0.0);
    let nearest = column.scale(HIGHEST_DIFFERENCE, 1).unwrap_or(white);
    let mut here = nearest;
    while let Some(next) =
        column.scale(HIGHEST_DIFFERENCE, 2 * distance).filter(|_| 2 * distance <= settings.farthest_neighbor)
    {
        if !(next > here * tolerance || next < here / tolerance) || next > settings.motion_growth * here {
            break;
        }
        (std, here, distance) = (next, next, 2 * distance);
        correlation = correlation_of(nearest / std);
    }
    Noise { std: std.max(floor), correlation, resolution }
}

/// A column whose differences are taken.
struct Column<'a> {
    times: &'a [f64],
    values: &'a [f64],
    /// Median step in time.
    step: f64,
    /// Whether all steps are the same, to a thousandth.
    even: bool,
    /// Fewest differences that give a scale.
    fewest: usize,
}

impl<'a> Column<'a> {
    fn new(times: &'a [f64], values: &'a [f64], fewest: usize) -> Self {
        let mut steps = steps(times);
        steps.sort_by(f64::total_cmp);
        let step = steps.get(steps.len() / 2).copied().unwrap_or(1.0);
        // A few gaps do not make a clock uneven.
        let quantile = |share: f64| steps.get((steps.len() as f64 * share) as usize).copied().unwrap_or(step);
        let even = (quantile(0.95) - quantile(0.05)).abs() <= 1e-3 * step;
        Self { times, values, step, even, fewest }
    }

    /// Robust standard deviation of the differences of an order, of samples so many apart, over that of white noise of
    /// variance one. None for too few differences.
    fn scale(&self, order: usize, distance: usize) -> Option<f64> {
        let span = order * distance;
        let windows = self.values.len().checked_sub(span)?;
        let longest = 1.5 * span as f64 * self.step;
        let binomial = weights(&(0..=order).map(|k| k as f64).collect::<Vec<_>>());
        let mut points = vec![0.0; order + 1];
        let mut sizes = Vec::with_capacity(windows);
        for start in 0..windows {
            if self.times[start + span] - self.times[start] > longest {
                continue;
            }
            let difference = |weights: &[f64]| -> f64 {
                weights.iter().enumerate().map(|(k, w)| w * self.values[start + k * distance]).sum()
            };
            let d = if self.even {
                difference(&binomial)
            } else {
                for (k, point) in points.iter_mut().enumerate() {
                    *point = (self.times[start + k * distance] - self.times[start]) / self.step;
                }
                difference(&weights(&points))
            };
            if d.is_finite() {
                sizes.push(d.abs());
            }
        }
        if sizes.len() < self.fewest { None } else { Some(robust_scale(&mut sizes)) }
    }
}

/// Weights of the divided difference over some points, of length one.
fn weights(points: &[f64]) -> Vec<f64> {
    let others = |k: usize| points.iter().enumerate().filter(move |(j, _)| *j != k).map(move |(_, p)| points[k] - p);
    let raw: Vec<f64> = (0..points.len()).map(|k| 1.0 / others(k).product::<f64>()).collect();
    let length = raw.iter().map(|w| w * w).sum::<f64>().sqrt();
    raw.into_iter().map(|w| w / length).collect()
}

/// Standard deviation of a normal variable from absolute values, those beyond three standard deviations left out.
fn robust_scale(sizes: &mut [f64]) -> f64 {
    /// Median of the absolute value of a standard normal variable.
    const MEDIAN: f64 = 0.674_489_750_196_081_7;
    /// Variance of a standard normal variable cut at three.
    const CUT: f64 = 0.973_337_011_400_9;
    let middle = sizes.len() / 2;
    let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
    let mut scale = *median / MEDIAN;
    for _ in 0..4 {
        let kept = sizes.iter().filter(|d| **d <= 3.0 * scale);
        let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), d| (sum + d * d, count + 1.0));
        if sum == 0.0 {
            return scale;
        }
        scale = f64::sqrt(sum / (count * CUT));
    }
    scale
}

/// Correlation φ of neighbors in noise whose correlation at k samples is φ^k, from its standard deviation as differences of
/// the highest order see it, over the true one.
fn correlation_of(ratio: f64) -> f64 {
    let binomial = weights(&(0..=HIGHEST_DIFFERENCE).map(|k| k as f64).collect::<Vec<_>>());
    let seen = |correlation: f64| -> f64 {
        let mut sum = 0.0;
        for (i, a) in binomial.iter().enumerate() {
            for (j, b) in binomial.iter().enumerate() {
                sum += a * b * correlation.powi(i.abs_diff(j) as i32);
            }
        }
        sum.max(0.0).sqrt()
    };
    let (mut low, mut high) = (-0.99, 0.9999);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if seen(middle) > ratio { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// The distance q of which all values are multiples, if there is one that is coarser than rounding, from at least `fewest` steps.
fn resolution(values: &[f64], fewest: usize) -> Option<f64> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let size = sorted.last()?.abs().max(sorted.first()?.abs());
    let rounding = 64.0 * f64::EPSILON * size;
    let steps: Vec<f64> = sorted.windows(2).map(|pair| pair[1] - pair[0]).filter(|d| *d > rounding).collect();
    if steps.len() < fewest {
        return None;
    }
    let step = steps.iter().copied().fold(f64::INFINITY, f64::min);
    // The smallest step is a multiple of q; better known from the widest of its multiples.
    let (whole, lengths) = steps.iter().filter(|d| **d < 1e3 * step).fold((0.0, 0.0), |(whole, lengths), d| {
        let multiple = (d / step).round();
        (whole + multiple, lengths + d)
    });
    let step = lengths / whole;
    let off = steps.iter().filter(|d| (*d / step - (*d / step).round()).abs() > 0.05 && **d < 1e3 * step).count();
    (step > 2.0 * rounding && off == 0).then_some(step)
}
