//! The switching functions σ of a system and their gradients, at the last point at which they were evaluated.

use crate::Switched;
use std::ops::Range;

/// Part of the absolute tolerance below which a switching function is rounding: what hangs on a sticking velocity
/// stays there.
pub(crate) const NEGLIGIBLE: f64 = 1e-4;
/// Size of σ, in units of the absolute tolerance, below which a direction has no meaning.
const ARRIVAL: f64 = 10.0;
/// How many times that size the σ of a switch may have that vanishes because those of others do: it is bounded by theirs.
const FOLLOWING: f64 = 100.0;

/// Switching functions and gradients of a system with `n` states, by component (`k` of all switches).
#[derive(Debug, Clone)]
pub(crate) struct Surfaces {
    n: usize,
    /// The components of each switch.
    pub(crate) parts: Vec<Range<usize>>,
    /// σ.
    pub(crate) sigma: Vec<f64>,
    /// `∂σ_i/∂x_j`, by rows.
    gradient: Vec<f64>,
    partial_t: Vec<f64>,
}

impl Surfaces {
    pub(crate) fn new(system: &dyn Switched) -> Self {
        let (n, mut k) = (system.dim(), 0);
        let part = |switch| {
            let first = k;
            k += system.components(switch);
            first..k
        };
        let parts = (0..system.switches()).map(part).collect();
        Self { n, parts, sigma: vec![0.0; k], gradient: vec![0.0; n * k], partial_t: vec![0.0; k] }
    }

    /// Evaluates σ.
    pub(crate) fn evaluate(&mut self, system: &mut dyn Switched, t: f64, x: &[f64]) {
        system.switching(t, x, &mut self.sigma);
    }

    /// Evaluates the gradients.
    pub(crate) fn differentiate(&mut self, system: &mut dyn Switched, t: f64, x: &[f64]) {
        system.switching_gradient(t, x, &mut self.gradient, &mut self.partial_t);
    }

    /// Whether a switch is a unit vector.
    pub(crate) fn is_vector(&self, switch: usize) -> bool {
        self.parts[switch].len() > 1
    }

    /// `|σ|` of a switch.
    pub(crate) fn size(&self, switch: usize) -> f64 {
        norm(&self.sigma[self.parts[switch].clone()])
    }

    /// `∇σ_i`.
    pub(crate) fn gradient(&self, i: usize) -> &[f64] {
        &self.gradient[i * self.n..(i + 1) * self.n]
    }

    /// `∂σ_i/∂t`.
    pub(crate) fn partial_t(&self, i: usize) -> f64 {
        self.partial_t[i]
    }

    /// `σ̇_i` for the velocity `dx`.
    pub(crate) fn rate(&self, i: usize, dx: &[f64]) -> f64 {
        self.gradient(i).iter().zip(dx).fold(self.partial_t[i], |sum, (g, v)| sum + g * v)
    }

    /// Size of the terms of `σ̇_i`.
    pub(crate) fn rate_scale(&self, i: usize, dx: &[f64]) -> f64 {
        self.gradient(i).iter().zip(dx).fold(self.partial_t[i].abs(), |sum, (g, v)| sum + (g * v).abs())
    }

    /// How far `σ_i` moves when every state moves by `size`.
    pub(crate) fn spread(&self, i: usize, size: f64) -> f64 {
        self.gradient(i).iter().map(|g| g.abs() * size).sum()
    }

    /// Rounding to expect in `σ_i` after a step of length `h` from `x` with velocity `dx`.
    pub(crate) fn noise(&self, i: usize, x: &[f64], dx: &[f64], h: f64) -> f64 {
        let motion = |j: usize| if h > 0.0 { h * dx[j].abs() } else { 0.0 };
        let terms = self.gradient(i).iter().enumerate().map(|(j, g)| g.abs() * (x[j].abs() + motion(j)));
        terms.sum::<f64>() * 8.0 * f64::EPSILON
    }

    /// The largest of the components of a switch.
    fn largest(&self, switch: usize, of: impl Fn(usize) -> f64) -> f64 {
        self.parts[switch].clone().map(of).fold(0.0, f64::max)
    }

    /// Rounding to expect in the σ of a switch at `x`.
    pub(crate) fn rounding(&self, switch: usize, x: &[f64]) -> f64 {
        self.largest(switch, |c| self.noise(c, x, &[], 0.0))
    }

    /// Size of σ that is rounding, at `x`, for the absolute tolerance `atol`.
    pub(crate) fn negligible(&self, switch: usize, x: &[f64], atol: f64) -> f64 {
        self.rounding(switch, x) + self.largest(switch, |c| self.spread(c, NEGLIGIBLE * atol))
    }

    /// Size of σ below which a unit vector that shrinks has arrived at zero.
    pub(crate) fn arrival_size(&self, switch: usize, x: &[f64], atol: f64) -> f64 {
        4.0 * self.rounding(switch, x) + self.largest(switch, |c| self.spread(c, ARRIVAL * atol))
    }

    /// Whether the σ of a switch has arrived at zero if those on which it depends have.
    pub(crate) fn may_follow(&self, switch: usize, x: &[f64], atol: f64) -> bool {
        self.size(switch) <= FOLLOWING * self.arrival_size(switch, x, atol)
    }
}

/// Euclidean norm.
pub(crate) fn norm(v: &[f64]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// `v / by`, in place.
pub(crate) fn divide(v: &mut [f64], by: f64) {
    for c in v {
        *c /= by;
    }
}
