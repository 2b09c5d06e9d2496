//! The signs and directions of switches: of those that stick, `s_K` such that `σ̇_K(t, x, s) = 0`; of unit vectors that
//! slide, `σ/|σ|`.
//!
//! `σ̇_i = ∂σ_i/∂t + ∇σ_i · f(t, x, s)`. In every mechanical system with dry friction `f` is affine in `s`, so that Newton
//! ends after one step; Broyden's update keeps the inverse Jacobian from one evaluation to the next.

use crate::{Mode, Switched};
use nalgebra::DMatrix;
use std::ops::Range;

/// Residual of `σ̇_i = 0`, relative to the influence of the signs on it.
const RESIDUAL: f64 = 1e-14;
/// Rounding of one sum of products.
const ROUNDING: f64 = 4e-15;

/// How far a sticking sign may pass 1 before the switch breaks loose: far above its rounding, far below notice.
const STICKING_EXCESS: f64 = 1e-11;

/// Solver of the sticking signs, with its scratch memory.
#[derive(Debug, Clone)]
pub(crate) struct Multipliers {
    pub(crate) n: usize,
    /// The components of each switch.
    pub(crate) parts: Vec<Range<usize>>,
    /// Static over sliding level of each switch.
    ratios: Vec<f64>,
    /// The signs and directions, `k`: ±1 or a unit vector where sliding, the solution where sticking.
    pub(crate) s: Vec<f64>,
    /// Unit vectors that slide along their σ.
    aimed: Vec<usize>,
    /// Unit vectors that slide in a direction that is kept, because σ has just left zero or is about to reach it.
    pub(crate) held: Vec<bool>,
    sigma: Vec<f64>,
    /// `∂σ_i/∂x_j` at the last point.
    pub(crate) gradient: Vec<f64>,
    /// `∂σ_i/∂t` at the last point.
    pub(crate) partial_t: Vec<f64>,
    /// The components that stick, in order.
    pub(crate) sticking: Vec<usize>,
    /// Inverse of `∂σ̇_K/∂s_K`; absent until it is needed.
    inverse: Option<DMatrix<f64>>,
    /// Row sums of `|∂σ̇_K/∂s_K|`.
    pub(crate) influence: Vec<f64>,
    residual: Vec<f64>,
    previous: Vec<f64>,
    pub(crate) delta: Vec<f64>,
    image: Vec<f64>,
    row: Vec<f64>,
    scratch: Vec<f64>,
    /// `∂f/∂s` by columns, and `∂σ̇_K/∂s_K`, of systems that are affine in their signs.
    pub(crate) by_sign: Vec<f64>,
    pub(crate) matrix: Vec<f64>,
    /// Evaluations of the right-hand side.
    pub(crate) evaluations: usize,
}

impl Multipliers {
    pub(crate) fn new(system: &impl Switched) -> Self {
        let n = system.dim();
        let mut parts = Vec::with_capacity(system.switches());
        let mut k = 0;
        for switch in 0..system.switches() {
            let first = k;
            k += system.components(switch);
            parts.push(first..k);
        }
        Self {
            n,
            s: vec![1.0; k],
            aimed: Vec::new(),
            held: vec![false; parts.len()],
            ratios: (0..parts.len()).map(|i| system.static_ratio(i).max(1.0)).collect(),
            parts,
            sigma: vec![0.0; k],
            gradient: vec![0.0; n * k],
            partial_t: vec![0.0; k],
            sticking: Vec::with_capacity(k),
            inverse: None,
            influence: vec![0.0; k],
            residual: vec![0.0; k],
            previous: vec![0.0; k],
            delta: vec![0.0; k],
            image: vec![0.0; k],
            row: vec![0.0; k],
            scratch: vec![0.0; n],
            by_sign: vec![0.0; n * k],
            matrix: vec![0.0; k * k],
            evaluations: 0,
        }
    }

    /// Takes over the modes: sets the sliding signs, and forgets the Jacobian if the sticking set is another.
    pub(crate) fn set_modes(&mut self, modes: &[Mode]) {
        let sticking = |i: &usize| modes[*i] == Mode::Sticking;
        let components = (0..modes.len()).filter(sticking).flat_map(|i| self.parts[i].clone());
        if !self.sticking.iter().copied().eq(components.clone()) {
            self.sticking = components.collect();
            self.inverse = None;
        }
        self.aimed.clear();
        for (i, mode) in modes.iter().enumerate() {
            let part = self.parts[i].clone();
            match mode {
                Mode::Sticking => {
                    let excess = (norm(&self.s[part.clone()]) / self.ratios[i]).max(1.0);
                    self.s[part].iter_mut().for_each(|s| *s /= excess);
                }
                _ if part.len() > 1 => self.aimed.push(i),
                sliding => self.s[part.start] = sliding.sign(),
            }
        }
    }

    /// Whether a switch is a unit vector.
    pub(crate) fn is_vector(&self, switch: usize) -> bool {
        self.parts[switch].len() > 1
    }

    /// How much further a sticking switch of this `size` may be loaded before it breaks loose.
    pub(crate) fn reserve(&self, switch: usize, size: f64) -> f64 {
        self.ratios[switch] + STICKING_EXCESS - size
    }

    /// The sliding mode that a switch takes when it breaks loose with its present sign or direction.
    pub(crate) fn sliding_mode(&self, switch: usize) -> Mode {
        if self.is_vector(switch) { Mode::Sliding } else { Mode::of_sign(self.s[self.parts[switch].start]) }
    }

    /// The size of the sign or direction of a switch.
    pub(crate) fn size(&self, switch: usize) -> f64 {
        norm(&self.s[self.parts[switch].clone()])
    }

    /// Holds the directions that slide at given values, scaled to unit length; none lets them follow σ again.
    pub(crate) fn hold(&mut self, directions: Option<&[f64]>) {
        for &i in &self.aimed {
            self.held[i] = directions.is_some();
            if let Some(directions) = directions {
                let part = self.parts[i].clone();
                let size = norm(&directions[part.clone()]);
                for c in part {
                    self.s[c] = directions[c] / size;
                }
            }
        }
    }

    /// Points the directions that are not held along σ; where σ is exactly zero they stay.
    pub(crate) fn aim(&mut self, system: &mut impl Switched, t: f64, x: &[f64]) {
        if self.aimed.iter().all(|&i| self.held[i]) {
            return;
        }
        system.switching(t, x, &mut self.sigma);
        for &i in &self.aimed {
            let size = norm(&self.sigma[self.parts[i].clone()]);
            if !self.held[i] && size != 0.0 {
                for c in self.parts[i].clone() {
                    self.s[c] = self.sigma[c] / size;
                }
            }
        }
    }

    /// For a sliding unit vector at a point with velocity `dx`: the rate `s·σ̇` of `|σ|`, by the gradients of the last point.
    pub(crate) fn radial_rate(&self, switch: usize, dx: &[f64]) -> f64 {
        self.parts[switch].clone().map(|c| self.s[c] * self.rate(c, dx)).sum()
    }

    /// Evaluates the gradients of the switching functions at a point, for [`Multipliers::rate`].
    pub(crate) fn gradients(&mut self, system: &mut impl Switched, t: f64, x: &[f64]) {
        system.switching_gradient(t, x, &mut self.gradient, &mut self.partial_t);
    }

    /// `σ̇_i` for the velocity `dx`, by the gradients of the last point.
    pub(crate) fn rate(&self, i: usize, dx: &[f64]) -> f64 {
        let row = &self.gradient[i * self.n..(i + 1) * self.n];
        row.iter().zip(dx).fold(self.partial_t[i], |sum, (g, v)| sum + g * v)
    }

    /// Size of the terms of `σ̇_i`.
    fn rate_scale(&self, i: usize, dx: &[f64]) -> f64 {
        let row = &self.gradient[i * self.n..(i + 1) * self.n];
        row.iter().zip(dx).fold(self.partial_t[i].abs(), |sum, (g, v)| sum + (g * v).abs())
    }

    /// Writes `f(t, x, s)` with the sticking signs solved for; false if there is no solution (or nothing finite).
    pub(crate) fn field(&mut self, system: &mut impl Switched, t: f64, x: &[f64], dx: &mut [f64]) -> bool {
        self.aim(system, t, x);
        if self.sticking.is_empty() {
            system.rhs(t, x, &self.s, dx);
            self.evaluations += 1;
            return true;
        }
        self.gradients(system, t, x);
        if self.solve_affine(system, t, x, dx) {
            return true;
        }
        let m = self.sticking.len();
        if self.inverse.is_none() {
            self.differentiate(system, t, x, dx);
        }
        for attempt in 0..2 {
            if self.newton(system, t, x, dx, 3 + 2 * m) {
                return true;
            }
            if attempt == 0 {
                if !self.s.iter().all(|s| s.is_finite()) {
                    self.reset_sticking();
                }
                self.differentiate(system, t, x, dx);
            }
        }
        false
    }

    /// Forgets the signs and the Jacobian, which may not be finite.
    pub(crate) fn reset(&mut self) {
        self.s.fill(0.0);
        self.inverse = None;
    }

    fn reset_sticking(&mut self) {
        for &i in &self.sticking {
            self.s[i] = 0.0;
        }
    }

    /// Newton's iteration with Broyden's update of the inverse Jacobian.
    fn newton(&mut self, system: &mut impl Switched, t: f64, x: &[f64], dx: &mut [f64], iterations: usize) -> bool {
        let m = self.sticking.len();
        for iteration in 0..=iterations {
            system.rhs(t, x, &self.s, dx);
            self.evaluations += 1;
            let mut converged = true;
            for (a, &i) in self.sticking.iter().enumerate() {
                let r = self.rate(i, dx);
                let scale = ROUNDING * self.rate_scale(i, dx) + RESIDUAL * self.influence[a];
                converged &= r.abs() <= scale;
                self.residual[a] = r;
            }
            if converged {
                return true;
            }
            if !self.residual[..m].iter().all(|r| r.is_finite()) {
                return false;
            }
            if iteration > 0 {
                self.broyden();
            }
            let Some(inverse) = &self.inverse else {
                return false;
            };
            for a in 0..m {
                let step: f64 = (0..m).map(|b| -inverse[(a, b)] * self.residual[b]).sum();
                self.delta[a] = step;
            }
            for (a, &i) in self.sticking.iter().enumerate() {
                self.s[i] += self.delta[a];
                self.previous[a] = self.residual[a];
            }
        }
        false
    }

    /// Broyden's update of the inverse Jacobian (Sherman–Morrison form) for the last change `Δ` of the signs and `y` of
    /// the residual: `H += (Δ − H y) Δᵀ H / (Δᵀ H y)`.
    fn broyden(&mut self) {
        let m = self.sticking.len();
        let Some(inverse) = &mut self.inverse else {
            return;
        };
        for b in 0..m {
            self.previous[b] = self.residual[b] - self.previous[b];
        }
        for a in 0..m {
            self.image[a] = (0..m).map(|b| inverse[(a, b)] * self.previous[b]).sum();
        }
        let denominator: f64 = (0..m).map(|a| self.delta[a] * self.image[a]).sum();
        let norm: f64 = (0..m).map(|a| self.delta[a] * self.delta[a]).sum();
        if denominator.abs() <= 1e-3 * norm {
            return;
        }
        for b in 0..m {
            self.row[b] = (0..m).map(|a| self.delta[a] * inverse[(a, b)]).sum();
        }
        for a in 0..m {
            let gain = (self.delta[a] - self.image[a]) / denominator;
            for b in 0..m {
                inverse[(a, b)] += gain * self.row[b];
            }
        }
    }

    /// The Jacobian `∂σ̇_K/∂s_K` by differences of unit length (exact where `f` is affine in `s`), and its
    /// (pseudo-)inverse: redundant switching functions share their force.
    fn differentiate(&mut self, system: &mut impl Switched, t: f64, x: &[f64], dx: &mut [f64]) {
        let m = self.sticking.len();
        system.rhs(t, x, &self.s, dx);
        self.evaluations += 1 + m;
        let mut jacobian = DMatrix::zeros(m, m);
        let mut velocity = std::mem::take(&mut self.scratch);
        for b in 0..m {
            let j = self.sticking[b];
            let s = self.s[j];
            let step = if s > 0.0 { -1.0 } else { 1.0 };
            self.s[j] = s + step;
            system.rhs(t, x, &self.s, &mut velocity);
            self.s[j] = s;
            for a in 0..m {
                let i = self.sticking[a];
                let row = &self.gradient[i * self.n..(i + 1) * self.n];
                let difference: f64 = (0..self.n).map(|l| row[l] * (velocity[l] - dx[l])).sum();
                jacobian[(a, b)] = difference / step;
            }
        }
        self.scratch = velocity;
        for a in 0..m {
            self.influence[a] = jacobian.row(a).iter().map(|v: &f64| v.abs()).sum();
        }
        if jacobian.iter().all(|v| v.is_finite()) {
            let size = jacobian.amax();
            self.inverse = match jacobian.clone().try_inverse() {
                Some(inverse) if inverse.amax() * size < 1e12 => Some(inverse),
                _ => {
                    // Signs without influence are arbitrary: take the smallest.
                    self.reset_sticking();
                    jacobian.pseudo_inverse(1e-12 * size).ok()
                }
            };
        } else {
            self.inverse = None;
        }
    }

    /// Solves at a point for the given modes and tells whether the modes are consistent there: sticking signs within
    /// `[−1, 1]` and directions in the unit ball, sliding switches of the zero set `zero` moving off to their own side
    /// (`strict`) or not to the other.
    pub(crate) fn consistent(
        &mut self,
        system: &mut impl Switched,
        (t, x): (f64, &[f64]),
        modes: &[Mode],
        zero: &[usize],
        strict: bool,
        dx: &mut [f64],
    ) -> bool {
        self.set_modes(modes);
        let leaving: Vec<usize> = zero.iter().copied().filter(|&i| modes[i] == Mode::Sliding).collect();
        for &i in &leaving {
            self.held[i] = true;
        }
        let solved =
            if leaving.is_empty() { self.field(system, t, x, dx) } else { self.leave(system, (t, x), &leaving, dx) };
        self.held.fill(false);
        if !solved {
            return false;
        }
        if self.sticking.is_empty() {
            self.gradients(system, t, x);
        }
        // What hangs on a sticking switch has the rounding of its force as rate.
        let rounding = 1e-12 * self.influence[..self.sticking.len()].iter().fold(0.0f64, |m, v| m.max(*v));
        zero.iter().all(|&i| {
            let part = self.parts[i].clone();
            let slack = |scale: f64| {
                let (rates, spread) = part.clone().fold((0.0f64, 0.0f64), |(r, s), c| {
                    (r.max(self.rate_scale(c, dx)), s.max(self.spread(c, rounding)))
                });
                scale * rates + spread
            };
            let away = match modes[i] {
                Mode::Sticking => return self.reserve(i, self.size(i)) >= 0.0,
                Mode::Sliding => self.radial_rate(i, dx),
                sliding => sliding.sign() * self.rate(part.start, dx),
            };
            if strict { away > 0.0 } else { away >= -slack(1e-9) }
        })
    }

    /// Rounding to expect in `σ_i` after a step of length `h` from `x` with velocity `dx`.
    pub(crate) fn noise(&self, i: usize, x: &[f64], dx: &[f64], h: f64) -> f64 {
        let row = &self.gradient[i * self.n..(i + 1) * self.n];
        let way = |j: usize| if h > 0.0 { h * dx[j].abs() } else { 0.0 };
        (0..self.n).map(|j| row[j].abs() * (x[j].abs() + way(j))).sum::<f64>() * 8.0 * f64::EPSILON
    }

    /// How far `σ_i` moves when every state moves by `size`.
    pub(crate) fn spread(&self, i: usize, size: f64) -> f64 {
        self.gradient[i * self.n..(i + 1) * self.n].iter().map(|g| g.abs() * size).sum()
    }

    /// Moves `x` by the shortest way to `σ_K(t, x) = 0`, so that what sticks does not creep.
    pub(crate) fn project(&mut self, system: &mut impl Switched, t: f64, x: &mut [f64], sigma: &mut [f64]) {
        let m = self.sticking.len();
        if m == 0 {
            return;
        }
        for _ in 0..3 {
            system.switching(t, x, sigma);
            if self.sticking.iter().all(|&i| sigma[i] == 0.0) {
                return;
            }
            self.gradients(system, t, x);
            let rows = |a: usize| {
                let i = self.sticking[a];
                &self.gradient[i * self.n..(i + 1) * self.n]
            };
            let dot = |a: usize, b: usize| -> f64 { rows(a).iter().zip(rows(b)).map(|(p, q)| p * q).sum() };
            if m == 1 {
                let gain = sigma[self.sticking[0]] / dot(0, 0);
                if !gain.is_finite() {
                    return;
                }
                for (j, g) in rows(0).iter().enumerate() {
                    x[j] -= gain * g;
                }
                continue;
            }
            let gram = DMatrix::from_fn(m, m, dot);
            let size = gram.amax();
            let Ok(inverse) = gram.pseudo_inverse(1e-12 * size) else {
                return;
            };
            for a in 0..m {
                let gain: f64 = (0..m).map(|b| inverse[(a, b)] * sigma[self.sticking[b]]).sum();
                for (j, g) in rows(a).iter().enumerate() {
                    x[j] -= gain * g;
                }
            }
        }
    }
}

/// Euclidean norm.
pub(crate) fn norm(v: &[f64]) -> f64 {
    v.iter().map(|c| c * c).sum::<f64>().sqrt()
}
