//! Smoothing splines: a sampled motion with its velocity and acceleration.

use std::f64::consts::TAU;

use crate::statistics::{median, steps};

/// Unknowns per sample: value, first and second derivative.
const N: usize = 3;
/// One more column for the right-hand side.
const WIDTH: usize = 2 * N + 1;

/// How much a spline smooths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bandwidth {
    /// The frequency in Hz at which half of the amplitude passes.
    Cutoff(f64),
    /// As generalized cross validation asks for (Craven and Wahba 1979).
    CrossValidated,
}

/// A smoothing spline of fifth degree: of all curves, the one with the least `Σ (y_k − f(t_k))² + λ ∫ f'''²`.
///
/// On evenly spaced samples it is a filter without phase, of the gain `1/(1 + (ω/ω_c)⁶)`: a Butterworth filter of third
/// order, run forwards and backwards. It is found in O(n) as the smoothed state of a triply integrated white noise
/// (Wahba 1978), by orthogonal transformations (Paige and Saunders 1977).
///
/// At the ends its third derivative vanishes, which that of the motion need not: within about half a period of the cutoff
/// from the ends, the second derivative is less exact.
#[derive(Clone, Debug, PartialEq)]
pub struct SmoothingSpline {
    /// The times of the samples, s.
    pub times: Vec<f64>,
    /// The curve at these times.
    pub values: Vec<f64>,
    /// Its time derivative.
    pub first: Vec<f64>,
    /// Its second time derivative.
    pub second: Vec<f64>,
    /// The frequency in Hz at which half of the amplitude passes.
    pub bandwidth: f64,
    /// Standard deviation of what was smoothed away, corrected for the degrees of freedom of the curve.
    pub residual: f64,
}

impl SmoothingSpline {
    /// The spline near `values` at increasing `times` of the same number; NaN is a lost value. None if fewer than four
    /// values are left, or for a cutoff that is not positive.
    pub fn fit(times: &[f64], values: &[f64], bandwidth: Bandwidth) -> Option<Self> {
        if times.len() != values.len() || values.iter().filter(|v| v.is_finite()).count() <= N {
            return None;
        }
        let samples = Samples::new(times, values);
        let cutoff = match bandwidth {
            Bandwidth::Cutoff(cutoff) if cutoff > 0.0 && cutoff.is_finite() => cutoff,
            Bandwidth::Cutoff(_) => return None,
            Bandwidth::CrossValidated => samples.cross_validated(),
        };
        let solution = samples.solve(cutoff);
        Some(solution.into_spline(times, cutoff))
    }

    /// Value, first and second derivative at `t`; beyond the ends the curve goes on as a parabola.
    pub fn at(&self, t: f64) -> [f64; 3] {
        let n = self.times.len();
        let knot = |k: usize| [self.values[k], self.first[k], self.second[k]];
        if t <= self.times[0] || t >= self.times[n - 1] {
            let k = if t <= self.times[0] { 0 } else { n - 1 };
            let (dt, [x, v, a]) = (t - self.times[k], knot(k));
            return [x + (v + 0.5 * a * dt) * dt, v + a * dt, a];
        }
        let k = self.times.partition_point(|s| *s <= t).clamp(1, n - 1);
        hermite(self.times[k] - self.times[k - 1], t - self.times[k - 1], knot(k - 1), knot(k))
    }
}

/// Value, velocity and acceleration along a sampled column, without phase: the smoothing spline whose gain is one half at
/// `cutoff` (Hz). None as [`SmoothingSpline::fit`].
pub fn smooth(values: &[f64], times: &[f64], cutoff: f64) -> Option<(Vec<f64>, Vec<f64>, Vec<f64>)> {
    let spline = SmoothingSpline::fit(times, values, Bandwidth::Cutoff(cutoff))?;
    Some((spline.values, spline.first, spline.second))
}

/// The polynomial of fifth degree with given value and derivatives at 0 and `h`, and its derivatives, at `t`.
fn hermite(h: f64, t: f64, [x0, v0, a0]: [f64; 3], [x1, v1, a1]: [f64; 3]) -> [f64; 3] {
    let s = t / h;
    let (v0, a0, v1, a1) = (v0 * h, a0 * h * h / 2.0, v1 * h, a1 * h * h / 2.0);
    // x0 + v0 s + a0 s² + s³ (c3 + c4 s + c5 s²) with the three conditions at s = 1.
    let (d, e, g) = (x1 - x0 - v0 - a0, v1 - v0 - 2.0 * a0, a1 - a0);
    let (c3, c4, c5) = (10.0 * d - 4.0 * e + g, -15.0 * d + 7.0 * e - 2.0 * g, 6.0 * d - 3.0 * e + g);
    let value = x0 + s * (v0 + s * (a0 + s * (c3 + s * (c4 + s * c5))));
    let slope = v0 + s * (2.0 * a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)));
    let curvature = 2.0 * a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5));
    [value, slope / h, curvature / (h * h)]
}

/// Samples to be smoothed.
struct Samples<'a> {
    times: &'a [f64],
    values: &'a [f64],
    /// Usual distance of values that are there, s.
    step: f64,
    count: f64,
}

/// Value and derivatives at every sample, in units of the time scale, and how good they are.
struct Solution {
    states: Vec<[f64; N]>,
    /// Unit of time, s.
    scale: f64,
    /// Sum of the squared distances from the samples.
    square: f64,
    /// Degrees of freedom: trace of the matrix that maps samples to the curve.
    freedom: f64,
    count: f64,
}

impl Solution {
    /// Generalized cross validation: the mean square, raised by the freedom of the curve.
    fn score(&self) -> f64 {
        let left = (self.count - self.freedom).max(f64::MIN_POSITIVE);
        self.count * self.square / (left * left)
    }

    fn into_spline(self, times: &[f64], bandwidth: f64) -> SmoothingSpline {
        let column = |k: usize| {
            let unit = self.scale.powi(k as i32);
            self.states.iter().map(|x| x[k] / unit).collect::<Vec<f64>>()
        };
        let left = (self.count - self.freedom).max(f64::MIN_POSITIVE);
        SmoothingSpline {
            times: times.to_vec(),
            values: column(0),
            first: column(1),
            second: column(2),
            bandwidth,
            residual: if self.square == 0.0 { 0.0 } else { (self.square / left).sqrt() },
        }
    }
}

impl<'a> Samples<'a> {
    fn new(times: &'a [f64], values: &'a [f64]) -> Self {
        let count = values.iter().filter(|v| v.is_finite()).count();
        let step = median(steps(times)).unwrap_or(f64::NAN);
        Self { times, values, step, count: count as f64 }
    }

    /// The cutoff in Hz with the least score, between one period over the whole run and the sampling rate.
    fn cross_validated(&self) -> f64 {
        let highest = 1.0 / self.step;
        let length = self.times[self.times.len() - 1] - self.times[0];
        let mut cutoff = highest;
        let mut best = (f64::INFINITY, highest);
        let mut ratio = 0.5;
        // From fine to smooth in octaves; the score falls while noise is removed, and rises for good once the motion is.
        while cutoff * length > 0.5 {
            let score = self.solve(cutoff).score();
            if score < best.0 {
                best = (score, cutoff);
            } else if score > 100.0 * best.0 {
                break;
            }
            cutoff *= ratio;
        }
        while ratio < 0.9 {
            ratio = f64::sqrt(ratio);
            for cutoff in [best.1 * ratio, (best.1 / ratio).min(highest)] {
                let score = self.solve(cutoff).score();
                if score < best.0 {
                    best = (score, cutoff);
                }
            }
        }
        best.1
    }

    /// The spline of a cutoff in Hz.
    fn solve(&self, cutoff: f64) -> Solution {
        let scale = 1.0 / (TAU * cutoff);
        let n = self.times.len();
        let unit = self.step / scale;
        // What is known of the state at a sample from those before: R x = z.
        let mut known = [[0.0; N + 1]; N];
        let mut links = Vec::with_capacity(n);
        let offset = self.values.iter().copied().find(|v| v.is_finite()).unwrap_or(0.0);
        for k in 0..n {
            if self.values[k].is_finite() {
                observe(&mut known, self.values[k] - offset);
            }
            if k + 1 < n {
                let (link, next) = advance(&known, (self.times[k + 1] - self.times[k]) / scale, unit);
                links.push(link);
                known = next;
            }
        }
        let mut x = back_substitute(&known);
        let mut covariance = gram_inverse(&inverse(&known));
        let mut states = vec![[0.0; N]; n];
        let (mut square, mut freedom) = (0.0, 0.0);
        for k in (0..n).rev() {
            if k + 1 < n {
                (x, covariance) = step_back(&links[k], &x, &covariance);
            }
            states[k] = [x[0] + offset, x[1], x[2]];
            if self.values[k].is_finite() {
                square += (self.values[k] - offset - x[0]).powi(2);
                freedom += covariance[0][0];
            }
        }
        Solution { states, scale, square, freedom, count: self.count }
    }
}

type Matrix = [[f64; N]; N];
/// `R` (upper triangle) and `z` of `R x = z`.
type Known = [[f64; N + 1]; N];
/// `R x_k + T x_{k+1} = z`.
type Link = [[f64; WIDTH]; N];

/// Takes in one value of the first component, by rotations.
fn observe(known: &mut Known, value: f64) {
    let mut row = [0.0; N + 1];
    (row[0], row[N]) = (1.0, value);
    for i in 0..N {
        let r = known[i][i].hypot(row[i]);
        if r == 0.0 {
            continue;
        }
        let (c, s) = (known[i][i] / r, row[i] / r);
        for j in i..=N {
            let (a, b) = (known[i][j], row[j]);
            known[i][j] = c * a + s * b;
            row[j] = c * b - s * a;
        }
    }
}

/// From one sample to the next, `h` later: `x_{k+1} = F x_k + w`, w of the covariance of a triply integrated white noise of
/// density `unit`, the usual distance of samples.
fn advance(known: &Known, h: f64, unit: f64) -> (Link, Known) {
    // Inverse of the Cholesky factor of [[1/20, 1/8, 1/6], [1/8, 1/3, 1/2], [1/6, 1/2, 1]].
    let (r5, r3) = (5f64.sqrt(), 3f64.sqrt());
    let factor = [[2.0 * r5, 0.0, 0.0], [-10.0 * r3, 4.0 * r3, 0.0], [20.0, -12.0, 3.0]];
    let row = (1.0 / (unit * h)).sqrt();
    let weights = [row / (h * h), row / h, row];
    let mut rows = [[0.0; WIDTH]; 2 * N];
    for i in 0..N {
        let w = [factor[i][0] * weights[0], factor[i][1] * weights[1], factor[i][2] * weights[2]];
        rows[i][..N].copy_from_slice(&[-w[0], -(w[0] * h + w[1]), -(w[0] * h * h / 2.0 + w[1] * h + w[2])]);
        rows[i][N..2 * N].copy_from_slice(&w);
        rows[N + i][..N].copy_from_slice(&known[i][..N]);
        rows[N + i][2 * N] = known[i][N];
    }
    triangularize(&mut rows);
    let mut link = [[0.0; WIDTH]; N];
    let mut next = [[0.0; N + 1]; N];
    for i in 0..N {
        link[i] = rows[i];
        next[i].copy_from_slice(&rows[N + i][N..]);
    }
    (link, next)
}

/// Householder reflections, as far as there are unknowns.
fn triangularize(rows: &mut [[f64; WIDTH]; 2 * N]) {
    for j in 0..2 * N - 1 {
        let norm = rows[j..].iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt();
        if norm == 0.0 {
            continue;
        }
        let head = if rows[j][j] > 0.0 { -norm } else { norm };
        let first = rows[j][j] - head;
        // v = (1, rows below / first), H = I − β v vᵀ
        let beta = -first / head;
        let mut v = [0.0; 2 * N];
        v[j] = 1.0;
        for i in j + 1..2 * N {
            v[i] = rows[i][j] / first;
            rows[i][j] = 0.0;
        }
        rows[j][j] = head;
        for column in j + 1..WIDTH {
            let dot: f64 = (j..2 * N).map(|i| v[i] * rows[i][column]).sum();
            for i in j..2 * N {
                rows[i][column] -= beta * dot * v[i];
            }
        }
    }
}

/// `R⁻¹` of an upper triangle.
fn inverse<const W: usize>(rows: &[[f64; W]; N]) -> Matrix {
    let mut out = [[0.0; N]; N];
    for column in 0..N {
        for i in (0..=column).rev() {
            let sum: f64 = (i + 1..=column).map(|j| rows[i][j] * out[j][column]).sum();
            out[i][column] = (f64::from(u8::from(i == column)) - sum) / rows[i][i];
        }
    }
    out
}

fn back_substitute(known: &Known) -> [f64; N] {
    let inverse = inverse(known);
    let mut x = [0.0; N];
    for i in 0..N {
        x[i] = (i..N).map(|j| inverse[i][j] * known[j][N]).sum();
    }
    x
}

/// `R⁻¹ R⁻ᵀ`
fn gram_inverse(inverse: &Matrix) -> Matrix {
    let mut out = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..N {
            out[i][j] = (0..N).map(|k| inverse[i][k] * inverse[j][k]).sum();
        }
    }
    out
}

/// State and covariance at a sample from those at the next.
fn step_back(link: &Link, next: &[f64; N], covariance: &Matrix) -> ([f64; N], Matrix) {
    let inverse = inverse(link);
    let mut rest = [0.0; N];
    for i in 0..N {
        rest[i] = link[i][2 * N] - (0..N).map(|j| link[i][N + j] * next[j]).sum::<f64>();
    }
    let mut x = [0.0; N];
    let mut by_next = [[0.0; N]; N];
    for i in 0..N {
        x[i] = (i..N).map(|j| inverse[i][j] * rest[j]).sum();
        for j in 0..N {
            by_next[i][j] = (i..N).map(|k| inverse[i][k] * link[k][N + j]).sum();
        }
    }
    let mut half = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..N {
            half[i][j] = (0..N).map(|k| by_next[i][k] * covariance[k][j]).sum();
        }
    }
    let mut out = gram_inverse(&inverse);
    for i in 0..N {
        for j in 0..N {
            out[i][j] += (0..N).map(|k| half[i][k] * by_next[j][k]).sum::<f64>();
        }
    }
    (x, out)
}
