//! The forces that hold what sticks: the signs `s_K` for which `σ̇_K(t, x, s) = 0`.
//!
//! `σ̇_i = ∂σ_i/∂t + ∇σ_i · f(t, x, s)`. In every mechanical system with dry friction `f` is affine in `s`: one evaluation and
//! one small linear solve. For others, Broyden's update (1965) keeps the inverse Jacobian of Newton's method from one evaluation
//! to the next. Where the sticking switches do not determine each other, they share the forces ([`Sharing`]).

use super::elimination::{eliminate, is_idle};
use super::sharing::Sharing;
use super::surfaces::Surfaces;
use crate::Switched;
use nalgebra::DMatrix;
use std::ops::Range;

/// Residual of `σ̇_i = 0`, relative to the influence of the signs on it.
const RESIDUAL: f64 = 1e-14;
/// Rounding of one sum of products.
const ROUNDING: f64 = 4e-15;
/// Pivots below this part of the largest entry mean redundant switches.
const SINGULAR: f64 = 1e-10;
/// Redundant switches may contradict each other by this part of the terms of their `σ̇`: rounding.
const CONTRADICTION: f64 = 1e-9;

/// A system at a point, with the gradients of its switching functions there.
pub(crate) struct At<'a> {
    pub(crate) system: &'a mut dyn Switched,
    pub(crate) surfaces: &'a Surfaces,
    pub(crate) t: f64,
    pub(crate) x: &'a [f64],
}

/// Solver of the sticking signs.
#[derive(Debug, Clone)]
pub(crate) struct Forces {
    /// The components that stick, in order.
    pub(crate) sticking: Vec<usize>,
    /// Whether they have turned out not to determine each other.
    pub(crate) redundant: bool,
    /// Row sums of `|∂σ̇_K/∂s_K|`.
    influence: Vec<f64>,
    /// Inverse of `∂σ̇_K/∂s_K`; absent until it is needed.
    inverse: Option<DMatrix<f64>>,
    /// `∂σ̇_K/∂s_K` itself where it has no inverse.
    singular: Option<DMatrix<f64>>,
    sharing: Sharing,
    residual: Vec<f64>,
    previous: Vec<f64>,
    delta: Vec<f64>,
    image: Vec<f64>,
    row: Vec<f64>,
    velocity: Vec<f64>,
    /// `∂f/∂s` by columns, and `∂σ̇_K/∂s_K` by rows, of systems that are affine in their signs.
    by_sign: Vec<f64>,
    matrix: Vec<f64>,
    /// Evaluations of the right-hand side.
    pub(crate) evaluations: usize,
}

impl Forces {
    /// For `n` states and switches with these components, whose arguments may become as large as `bounds`.
    pub(crate) fn new(n: usize, parts: &[Range<usize>], bounds: &[f64]) -> Self {
        let k = parts.last().map_or(0, |part| part.end);
        let row = || vec![0.0; k];
        Self {
            sticking: Vec::with_capacity(k),
            redundant: false,
            influence: row(),
            inverse: None,
            singular: None,
            sharing: Sharing::new(parts, bounds),
            residual: row(),
            previous: row(),
            delta: row(),
            image: row(),
            row: row(),
            velocity: vec![0.0; n],
            by_sign: vec![0.0; n * k],
            matrix: vec![0.0; k * k],
            evaluations: 0,
        }
    }

    /// Takes over the components that stick; forgets the Jacobian if they are others.
    pub(crate) fn hold(&mut self, components: impl Iterator<Item = usize> + Clone) {
        if !self.sticking.iter().copied().eq(components.clone()) {
            self.sticking = components.collect();
            self.redundant = false;
            self.forget();
        }
    }

    /// Forgets the Jacobian, which may not be finite.
    pub(crate) fn forget(&mut self) {
        self.inverse = None;
        self.singular = None;
    }

    /// Largest influence of the sticking signs on their `σ̇`.
    pub(crate) fn largest_influence(&self) -> f64 {
        self.influence[..self.sticking.len()].iter().fold(0.0f64, |m, v| m.max(*v))
    }

    /// Solves for the sticking signs in `s` and writes `f(t, x, s)`; false if there is no solution.
    pub(crate) fn solve(&mut self, at: &mut At<'_>, s: &mut [f64], dx: &mut [f64]) -> bool {
        if self.solve_affine(at, s, dx) {
            return true;
        }
        if self.inverse.is_none() && self.singular.is_none() {
            self.differentiate(at, s, dx);
        }
        for attempt in 0..2 {
            if self.newton(at, s, dx) {
                return true;
            }
            if attempt == 0 {
                if !s.iter().all(|s| s.is_finite()) {
                    self.sticking.iter().for_each(|&i| s[i] = 0.0);
                }
                self.differentiate(at, s, dx);
            }
        }
        false
    }

    /// False if the system is not affine in its signs, or if they do not determine each other: then nothing is changed but `dx`.
    fn solve_affine(&mut self, at: &mut At<'_>, s: &mut [f64], dx: &mut [f64]) -> bool {
        if !at.system.affine(at.t, at.x, s, dx, &mut self.by_sign) {
            return false;
        }
        self.evaluations += 1;
        let (m, n) = (self.sticking.len(), dx.len());
        let mut size = 0.0f64;
        for (a, &i) in self.sticking.iter().enumerate() {
            let mut influence = 0.0;
            for (b, &j) in self.sticking.iter().enumerate() {
                let column = &self.by_sign[j * n..(j + 1) * n];
                let entry: f64 = at.surfaces.gradient(i).iter().zip(column).map(|(g, v)| g * v).sum();
                self.matrix[a * m + b] = entry;
                influence += entry.abs();
            }
            self.influence[a] = influence;
            size = size.max(influence);
            self.delta[a] = -at.surfaces.rate(i, dx);
        }
        if !eliminate(&mut self.matrix[..m * m], &mut self.delta[..m], m, SINGULAR * size) {
            return self.share_affine(at, s, dx);
        }
        for (a, &j) in self.sticking.iter().enumerate() {
            if is_idle(&self.matrix, m, a) {
                // A component that moves nothing takes no part of what the others may resist.
                self.delta[a] = -s[j];
                self.redundant = true;
            }
            s[j] += self.delta[a];
            for (d, v) in dx.iter_mut().zip(&self.by_sign[j * n..(j + 1) * n]) {
                *d += self.delta[a] * v;
            }
        }
        true
    }

    /// As [`Forces::solve_affine`], after it has written `∂f/∂s`, where the sticking signs do not determine each other.
    #[cold]
    fn share_affine(&mut self, at: &mut At<'_>, s: &mut [f64], dx: &mut [f64]) -> bool {
        let (m, n) = (self.sticking.len(), dx.len());
        self.redundant = true;
        for (a, &i) in self.sticking.iter().enumerate() {
            self.residual[a] = -at.surfaces.rate(i, dx);
            for (b, &j) in self.sticking.iter().enumerate() {
                let column = &self.by_sign[j * n..(j + 1) * n];
                let entry: f64 = at.surfaces.gradient(i).iter().zip(column).map(|(g, v)| g * v).sum();
                self.matrix[a * m + b] = entry;
                self.residual[a] += entry * s[j];
            }
        }
        let (matrix, right) = (&mut self.matrix[..m * m], &mut self.residual[..m]);
        if !self.sharing.solve(&self.sticking, matrix, right, &mut self.delta[..m]) {
            return false;
        }
        self.velocity.copy_from_slice(dx);
        for (a, &j) in self.sticking.iter().enumerate() {
            let change = self.delta[a] - s[j];
            for (d, v) in self.velocity.iter_mut().zip(&self.by_sign[j * n..(j + 1) * n]) {
                *d += change * v;
            }
        }
        for (a, &i) in self.sticking.iter().enumerate() {
            let terms = at.surfaces.rate_scale(i, &self.velocity) + self.influence[a];
            if at.surfaces.rate(i, &self.velocity).abs() > CONTRADICTION * terms {
                return false;
            }
        }
        dx.copy_from_slice(&self.velocity);
        self.sticking.iter().zip(&self.delta).for_each(|(&j, &shared)| s[j] = shared);
        true
    }

    /// Newton's iteration with Broyden's update of the inverse Jacobian.
    fn newton(&mut self, at: &mut At<'_>, s: &mut [f64], dx: &mut [f64]) -> bool {
        let m = self.sticking.len();
        for iteration in 0..=3 + 2 * m {
            at.system.rhs(at.t, at.x, s, dx);
            self.evaluations += 1;
            let mut converged = true;
            for (a, &i) in self.sticking.iter().enumerate() {
                let r = at.surfaces.rate(i, dx);
                let scale = ROUNDING * at.surfaces.rate_scale(i, dx) + RESIDUAL * self.influence[a];
                converged &= r.abs() <= scale;
                self.residual[a] = r;
            }
            if converged {
                return true;
            }
            if !self.residual[..m].iter().all(|r| r.is_finite()) {
                return false;
            }
            if let Some(jacobian) = &self.singular {
                for a in 0..m {
                    self.row[a] = -self.residual[a];
                    for (b, &j) in self.sticking.iter().enumerate() {
                        self.matrix[a * m + b] = jacobian[(a, b)];
                        self.row[a] += jacobian[(a, b)] * s[j];
                    }
                }
                let (matrix, right) = (&mut self.matrix[..m * m], &mut self.row[..m]);
                if !self.sharing.solve(&self.sticking, matrix, right, &mut self.delta[..m]) {
                    return false;
                }
                self.sticking.iter().zip(&self.delta).for_each(|(&j, &shared)| s[j] = shared);
                continue;
            }
            if iteration > 0 {
                self.broyden();
            }
            let Some(inverse) = &self.inverse else {
                return false;
            };
            for (a, &i) in self.sticking.iter().enumerate() {
                self.delta[a] = (0..m).map(|b| -inverse[(a, b)] * self.residual[b]).sum();
                s[i] += self.delta[a];
            }
            self.previous[..m].copy_from_slice(&self.residual[..m]);
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

    /// The Jacobian `∂σ̇_K/∂s_K` by differences of unit length (exact where `f` is affine in `s`), and its inverse if it has one:
    /// redundant switching functions share their force.
    fn differentiate(&mut self, at: &mut At<'_>, s: &mut [f64], dx: &mut [f64]) {
        let m = self.sticking.len();
        at.system.rhs(at.t, at.x, s, dx);
        self.evaluations += 1 + m;
        let mut jacobian = DMatrix::zeros(m, m);
        for (b, &j) in self.sticking.iter().enumerate() {
            let before = s[j];
            let step = if before > 0.0 { -1.0 } else { 1.0 };
            s[j] = before + step;
            at.system.rhs(at.t, at.x, s, &mut self.velocity);
            s[j] = before;
            for (a, &i) in self.sticking.iter().enumerate() {
                let change = self.velocity.iter().zip(&*dx).map(|(v, d)| v - d);
                let difference: f64 = at.surfaces.gradient(i).iter().zip(change).map(|(g, c)| g * c).sum();
                jacobian[(a, b)] = difference / step;
            }
        }
        for a in 0..m {
            self.influence[a] = jacobian.row(a).iter().map(|v: &f64| v.abs()).sum();
        }
        self.forget();
        if jacobian.iter().all(|v| v.is_finite()) {
            let size = jacobian.amax();
            self.inverse = jacobian.clone().try_inverse().filter(|inverse| inverse.amax() * size < 1e12);
            if self.inverse.is_none() {
                self.singular = Some(jacobian);
                self.redundant = true;
            }
        }
    }
}
