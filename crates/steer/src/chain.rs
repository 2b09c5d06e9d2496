//! Sinusoids that move the chain z1' = v1, z2' = v2, z3' = z2 v1, …, zn' = z(n−1) v1 from one point to another.
//!
//! All at once (Tilbury, Murray, and Sastry 1995): z1 moves along a curve that is chosen first; the others then depend on v2 affinely,
//! and the amplitudes of v2 solve a linear system.

use std::f64::consts::PI;

use bracketry_numerics::least_squares::Factored;
use nalgebra::{DMatrix, DVector};

/// Steps of the integration of the chain.
const STEPS: usize = 300;
/// Singular values below this part of the largest are taken for zero: the chain is not controllable along this curve.
const RANK: f64 = 1e-9;

/// Inputs of the chain over the time from 0 to 1, zero at both ends.
#[derive(Clone, Debug)]
pub(crate) struct ChainInputs {
    /// z1(1) − z1(0).
    shift: f64,
    /// How far z1 swings aside.
    swing: f64,
    /// Amplitudes of sin(kπs), k = 1, 2, …, in v2.
    amplitudes: Vec<f64>,
}

impl ChainInputs {
    pub(crate) fn at(&self, s: f64) -> [f64; 2] {
        let second = self.amplitudes.iter().zip(1..).map(|(b, k)| b * (f64::from(k) * PI * s).sin()).sum();
        [first(self.shift, self.swing, s), second]
    }
}

/// v1 = shift (1 − cos 2πs) + π swing sin 2πs.
fn first(shift: f64, swing: f64, s: f64) -> f64 {
    let (sin, cos) = (2.0 * PI * s).sin_cos();
    shift * (1.0 - cos) + PI * swing * sin
}

/// z2 … zn at s = 1, from their values at 0.
fn response(start: &[f64], v1: impl Fn(f64) -> f64, v2: impl Fn(f64) -> f64) -> Vec<f64> {
    let rate = |s: f64, z: &[f64]| -> Vec<f64> {
        let v = v1(s);
        let mut rates = vec![v2(s)];
        rates.extend(z[..z.len() - 1].iter().map(|z| z * v));
        rates
    };
    let mut z = start.to_vec();
    let h = 1.0 / STEPS as f64;
    for i in 0..STEPS {
        let s = i as f64 * h;
        z = runge_kutta(s, &z, h, rate);
    }
    z
}

/// One step of the classical method of order 4.
pub(crate) fn runge_kutta(t: f64, x: &[f64], h: f64, mut rate: impl FnMut(f64, &[f64]) -> Vec<f64>) -> Vec<f64> {
    let along = |x: &[f64], k: &[f64], h: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + h * k).collect() };
    let k1 = rate(t, x);
    let k2 = rate(t + h / 2.0, &along(x, &k1, h / 2.0));
    let k3 = rate(t + h / 2.0, &along(x, &k2, h / 2.0));
    let k4 = rate(t + h, &along(x, &k3, h));
    (0..x.len()).map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])).collect()
}

/// Inputs from `start` to `end` for which z1 swings aside by `swing`; `None` where the chain is not controllable along that.
pub(crate) fn chain_inputs(start: &[f64], end: &[f64], swing: f64) -> Option<ChainInputs> {
    let (n, shift) = (start.len(), end[0] - start[0]);
    let v1 = |s: f64| first(shift, swing, s);
    let count = n + 1;
    let free = response(&start[1..], v1, |_| 0.0);
    let columns: Vec<DVector<f64>> = (1..=count)
        .map(|k| {
            // Slow sines first: the solution has the least sum of squares of k times the amplitude.
            let unit = response(&vec![0.0; n - 1], v1, |s| (k as f64 * PI * s).sin() / k as f64);
            DVector::from_vec(unit)
        })
        .collect();
    let gap = DVector::from_fn(n - 1, |i, _| end[i + 1] - free[i]);
    let matrix = DMatrix::from_columns(&columns);
    if !matrix.iter().chain(gap.iter()).all(|v| v.is_finite()) {
        return None;
    }
    // Rows of very different size are equally important.
    let sizes: Vec<f64> = matrix.row_iter().map(|row| row.norm()).collect();
    if sizes.iter().any(|s| *s < 1e-12) {
        return None;
    }
    let scaled = DMatrix::from_fn(n - 1, count, |i, j| matrix[(i, j)] / sizes[i]);
    let gap = DVector::from_fn(n - 1, |i, _| gap[i] / sizes[i]);
    let factored = Factored::new(&scaled, RANK)?;
    if factored.rank() < n - 1 {
        return None;
    }
    let solution = factored.solve(&gap, 0.0);
    Some(ChainInputs { shift, swing, amplitudes: solution.iter().zip(1..).map(|(b, k)| b / f64::from(k)).collect() })
}
