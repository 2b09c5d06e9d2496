//! Cubic smoothing splines whose ends need not be straight.

use crate::statistics::median;

/// Relative rounding below which a column counts as exact.
const EXACT: f64 = 1e-13;
/// Neighbors that sixth differences combine; shorter columns are interpolated.
const WINDOW: usize = 7;

/// Samples at either end through which a cubic is fitted for the second derivative there.
const END: usize = 7;

/// A cubic smoothing spline after Reinsch (1967): of all curves whose root mean square distance from the
/// samples is that of their noise, the one with the least `∫ (f − p)''²`. The cubic `p` has the second derivatives of
/// the motion at both ends, so that the spline need not be straight there.
///
/// Not the quintic [`SmoothingSpline`](super::SmoothingSpline), whose third derivative vanishes at the ends: a plate is simulated from the
/// first sample on, where that spline's acceleration is less exact.
#[derive(Clone, Debug)]
pub struct ReinschSpline {
    times: Vec<f64>,
    values: Vec<f64>,
    /// Second derivatives at the knots.
    curvatures: Vec<f64>,
    ends: End,
}

/// A cubic that has given second derivatives at the ends of an interval, and vanishes there.
#[derive(Clone, Debug, Default)]
struct End {
    from: f64,
    length: f64,
    /// Second derivatives at both ends.
    curvatures: [f64; 2],
}

impl End {
    /// The cubic with the second derivatives of the motion at its ends; zero for too few samples.
    fn of(times: &[f64], values: &[f64]) -> Self {
        let n = times.len();
        if n < END {
            return Self::default();
        }
        let curvatures = [
            end_curvature(&times[..END], &values[..END], times[0]),
            end_curvature(&times[n - END..], &values[n - END..], times[n - 1]),
        ];
        Self { from: times[0], length: times[n - 1] - times[0], curvatures }
    }

    /// Value, first and second derivative.
    fn at(&self, t: f64) -> [f64; 3] {
        if self.length == 0.0 {
            return [0.0; 3];
        }
        let (h, [m0, m1]) = (self.length, self.curvatures);
        let b = (t - self.from) / h;
        let a = 1.0 - b;
        [
            ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0,
            ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * h / 6.0,
            a * m0 + b * m1,
        ]
    }
}

/// Second derivative at `at` of the cubic that is nearest to the samples.
fn end_curvature(times: &[f64], values: &[f64], at: f64) -> f64 {
    let reach = times.iter().map(|t| (t - at).abs()).fold(0.0, f64::max);
    // Normal equations in the powers of the scaled time, solved by elimination; they are positive definite.
    let mut rows = [[0.0; 5]; 4];
    for (t, v) in times.iter().zip(values) {
        let s = (t - at) / reach;
        let powers = [1.0, s, s * s, s * s * s];
        for i in 0..4 {
            for j in 0..4 {
                rows[i][j] += powers[i] * powers[j];
            }
            rows[i][4] += powers[i] * v;
        }
    }
    for i in 0..4 {
        for k in i + 1..4 {
            let factor = rows[k][i] / rows[i][i];
            for j in i..5 {
                rows[k][j] -= factor * rows[i][j];
            }
        }
    }
    let cubic = rows[3][4] / rows[3][3];
    let square = (rows[2][4] - rows[2][3] * cubic) / rows[2][2];
    2.0 * square / (reach * reach)
}

impl ReinschSpline {
    /// The spline through or near `values` at increasing `times`, of equal length, at least one. The noise is estimated
    /// from the sixth differences, in which a smooth motion vanishes.
    pub fn fit(times: &[f64], values: &[f64]) -> Self {
        let n = times.len();
        let ends = End::of(times, values);
        let (curve, values) = (values, values.iter().zip(times).map(|(v, t)| v - ends.at(*t)[0]).collect::<Vec<_>>());
        let values = values.as_slice();
        let size = curve.iter().map(|v| v.abs()).fold(0.0, f64::max);
        let noise = noise(curve);
        let interpolating = solve(times, values, 0.0);
        let (values, curvatures) = if n < WINDOW || noise <= EXACT * size {
            interpolating
        } else {
            let distance = |fitted: &[f64]| {
                let sum: f64 = fitted.iter().zip(values).map(|(f, v)| (f - v) * (f - v)).sum();
                (sum / n as f64).sqrt()
            };
            // The distance grows with the weight of the curvature; the weight has the unit s³.
            let step = (times[n - 1] - times[0]) / (n - 1) as f64;
            let (mut low, mut high) = (step.powi(3) * 1e-8, step.powi(3) * 1e12);
            for _ in 0..60 {
                let weight = (low * high).sqrt();
                if distance(&solve(times, values, weight).0) < noise { low = weight } else { high = weight }
            }
            solve(times, values, low)
        };
        Self { times: times.to_vec(), values, curvatures, ends }
    }

    /// The times of the samples.
    pub fn knots(&self) -> &[f64] {
        &self.times
    }

    /// Value, first and second derivative at `t`; beyond the ends the curve goes on as a parabola.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let n = self.times.len();
        if n == 1 {
            return [self.values[0], 0.0, 0.0];
        }
        let k = self.times.partition_point(|s| *s <= t).clamp(1, n - 1);
        let (t0, t1) = (self.times[k - 1], self.times[k]);
        let inside = t.clamp(self.times[0], self.times[n - 1]);
        let h = t1 - t0;
        let (a, b) = ((t1 - inside) / h, (inside - t0) / h);
        let (f, m) = (&self.values, &self.curvatures);
        let [p, dp, ddp] = self.ends.at(inside);
        let value = a * f[k - 1] + b * f[k] + ((a * a * a - a) * m[k - 1] + (b * b * b - b) * m[k]) * h * h / 6.0 + p;
        let slope =
            (f[k] - f[k - 1]) / h + ((3.0 * b * b - 1.0) * m[k] - (3.0 * a * a - 1.0) * m[k - 1]) * h / 6.0 + dp;
        let curvature = a * m[k - 1] + b * m[k] + ddp;
        // Beyond the ends a parabola: a jump may lie up to one sample after the last one of its piece.
        let beyond = t - inside;
        [value + (slope + 0.5 * curvature * beyond) * beyond, slope + curvature * beyond, curvature]
    }
}

/// Standard deviation of independent noise that explains the sixth differences of `values`, by their median.
pub fn noise(values: &[f64]) -> f64 {
    const BINOMIAL: [f64; WINDOW] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];
    let difference = |w: &[f64]| w.iter().zip(BINOMIAL).map(|(v, c)| v * c).sum::<f64>().abs();
    let middle = median(values.windows(WINDOW).map(difference).collect());
    // Half of a normal variable's values lie within 0.6745 standard deviations.
    let spread: f64 = BINOMIAL.iter().map(|c| c * c).sum::<f64>().sqrt();
    middle.map_or(0.0, |middle| middle / (0.6745 * spread))
}

/// Values and second derivatives at the knots of the spline that minimizes `Σ (f − y)² + weight ∫ f''²`: the solution of
/// `(R + weight QᵀQ) γ = Qᵀ y`, `f = y − weight Q γ` (Green and Silverman 1994, section 2.3), by a banded LDLᵀ
/// factorization.
fn solve(times: &[f64], y: &[f64], weight: f64) -> (Vec<f64>, Vec<f64>) {
    let n = times.len();
    if n < 3 {
        return (y.to_vec(), vec![0.0; n]);
    }
    let h: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    let inner = n - 2;
    // Column k of Q has the entries q[k] at the knots k, k + 1, k + 2.
    let q: Vec<[f64; 3]> = (0..inner).map(|k| [1.0 / h[k], -1.0 / h[k] - 1.0 / h[k + 1], 1.0 / h[k + 1]]).collect();
    let dot = |k: usize, j: usize| -> f64 {
        let shift = j - k;
        (shift..3).map(|i| q[k][i] * q[j][i - shift]).sum()
    };
    // The matrix by diagonals, factorized in place: unit lower triangle with two diagonals below, and D.
    let mut diagonal = vec![0.0; inner];
    let mut first = vec![0.0; inner];
    let mut second = vec![0.0; inner];
    let mut rhs: Vec<f64> = (0..inner).map(|k| (0..3).map(|i| q[k][i] * y[k + i]).sum()).collect();
    for k in 0..inner {
        let mut d = (h[k] + h[k + 1]) / 3.0 + weight * dot(k, k);
        let mut e = if k + 1 < inner { h[k + 1] / 6.0 + weight * dot(k, k + 1) } else { 0.0 };
        let f = if k + 2 < inner { weight * dot(k, k + 2) } else { 0.0 };
        if k >= 1 {
            d -= first[k - 1] * first[k - 1] * diagonal[k - 1];
            e -= first[k - 1] * second[k - 1] * diagonal[k - 1];
            rhs[k] -= first[k - 1] * rhs[k - 1];
        }
        if k >= 2 {
            d -= second[k - 2] * second[k - 2] * diagonal[k - 2];
            rhs[k] -= second[k - 2] * rhs[k - 2];
        }
        diagonal[k] = d;
        (first[k], second[k]) = (e / d, f / d);
    }
    let mut gamma = rhs;
    for k in (0..inner).rev() {
        gamma[k] /= diagonal[k];
        if k + 1 < inner {
            gamma[k] -= first[k] * gamma[k + 1];
        }
        if k + 2 < inner {
            gamma[k] -= second[k] * gamma[k + 2];
        }
    }
    let mut values = y.to_vec();
    for k in 0..inner {
        for i in 0..3 {
            values[k + i] -= weight * q[k][i] * gamma[k];
        }
    }
    let mut curvatures = vec![0.0; n];
    curvatures[1..=inner].copy_from_slice(&gamma);
    (values, curvatures)
}
