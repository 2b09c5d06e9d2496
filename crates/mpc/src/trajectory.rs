//! States and inputs over a horizon.

use crate::error::{MpcError, check_length};

/// Inputs u_0 … u_{N−1}, constant over their interval, and states x_0 … x_N at the grid points.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedTrajectory {
    n: usize,
    m: usize,
    x: Vec<f64>,
    u: Vec<f64>,
}

impl PlannedTrajectory {
    /// A trajectory that rests at `x` with the inputs `u` for `steps` intervals.
    pub fn constant(steps: usize, x: &[f64], u: &[f64]) -> Self {
        Self { n: x.len(), m: u.len(), x: x.repeat(steps + 1), u: u.repeat(steps) }
    }

    /// A trajectory from rows of states (N + 1 of them) and inputs (N).
    ///
    /// # Errors
    /// If the numbers of rows or the lengths of rows do not agree.
    pub fn from_rows(x: &[Vec<f64>], u: &[Vec<f64>]) -> Result<Self, MpcError> {
        check_length("the list of states", x.len(), u.len() + 1)?;
        let (n, m) = (x[0].len(), u.first().map_or(0, Vec::len));
        for row in x {
            check_length("a state", row.len(), n)?;
        }
        for row in u {
            check_length("an input", row.len(), m)?;
        }
        Ok(Self { n, m, x: x.concat(), u: u.concat() })
    }

    /// Number of intervals N.
    pub fn steps(&self) -> usize {
        self.x.len() / self.n.max(1) - 1
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.n
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.m
    }

    /// The state at grid point k, 0 ≤ k ≤ N.
    pub fn x(&self, k: usize) -> &[f64] {
        &self.x[k * self.n..(k + 1) * self.n]
    }

    /// The input over interval k, 0 ≤ k < N.
    pub fn u(&self, k: usize) -> &[f64] {
        &self.u[k * self.m..(k + 1) * self.m]
    }

    /// The state at grid point k, to be changed.
    pub fn x_mut(&mut self, k: usize) -> &mut [f64] {
        &mut self.x[k * self.n..(k + 1) * self.n]
    }

    /// The input over interval k, to be changed.
    pub fn u_mut(&mut self, k: usize) -> &mut [f64] {
        &mut self.u[k * self.m..(k + 1) * self.m]
    }

    /// Makes every interval rest at `x` with the input `u`.
    pub(crate) fn set(&mut self, x: &[f64], u: &[f64]) {
        self.x.chunks_exact_mut(self.n.max(1)).for_each(|row| row.copy_from_slice(x));
        self.u.chunks_exact_mut(self.m.max(1)).for_each(|row| row.copy_from_slice(u));
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.x.iter().chain(&self.u).all(|v| v.is_finite())
    }

    /// The trajectory of the first `n` states alone.
    pub(crate) fn first_states(&self, n: usize) -> Self {
        let rows = (0..=self.steps()).flat_map(|k| self.x(k)[..n].iter().copied());
        Self { n, m: self.m, x: rows.collect(), u: self.u.clone() }
    }

    /// Takes over another trajectory of more states, as [`PlannedTrajectory::first_states`].
    pub(crate) fn copy_first_states(&mut self, other: &Self) {
        self.x.clear();
        for k in 0..=other.steps() {
            self.x.extend_from_slice(&other.x(k)[..self.n]);
        }
        self.u.clone_from(&other.u);
    }

    /// Drops the first interval; the horizon becomes one shorter.
    pub(crate) fn drop_first(&mut self) {
        self.x.drain(..self.n);
        self.u.drain(..self.m);
    }

    /// Moves everything one interval earlier; the last input is kept and the last state must be filled in.
    pub(crate) fn shift(&mut self) {
        self.x.copy_within(self.n.., 0);
        if self.u.len() > self.m {
            self.u.copy_within(self.m.., 0);
        }
    }

    /// self + alpha·(dx, du), where dx starts at x_0.
    pub(crate) fn moved(&self, alpha: f64, dx: &[f64], du: &[f64]) -> Self {
        let add = |a: &[f64], d: &[f64]| a.iter().zip(d).map(|(a, d)| a + alpha * d).collect();
        Self { n: self.n, m: self.m, x: add(&self.x, dx), u: add(&self.u, du) }
    }

    /// Takes over the numbers and the length of another trajectory of the same states and inputs.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.x.clone_from(&other.x);
        self.u.clone_from(&other.u);
    }

    /// Adds alpha·(dx, du), where dx starts at x_0.
    pub(crate) fn add(&mut self, alpha: f64, dx: &[f64], du: &[f64]) {
        self.x.iter_mut().zip(dx).for_each(|(a, d)| *a += alpha * d);
        self.u.iter_mut().zip(du).for_each(|(a, d)| *a += alpha * d);
    }

    pub(crate) fn clamp_inputs(&mut self, bounds: &[(f64, f64)]) {
        for row in self.u.chunks_exact_mut(self.m.max(1)) {
            for (v, b) in row.iter_mut().zip(bounds) {
                *v = v.clamp(b.0, b.1);
            }
        }
    }
}
