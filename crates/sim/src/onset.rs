//! The directions in which unit vectors leave σ = 0: `s` such that `σ̇(s) = λ s` with `|s| = 1`, `λ ≥ 0`.
//!
//! These are the fixed points of `s ↦ (κ s + σ̇(s))/|κ s + σ̇(s)|`, which dry friction, being dissipative, makes a contraction
//! for `κ` as large as its influence; Newton's method on the sphere ends the iteration.

use crate::Switched;
use crate::multipliers::{Multipliers, norm};
use nalgebra::{DMatrix, DVector};

/// Fixed-point iterations before Newton's.
const FIXED_POINT: usize = 30;
const NEWTON: usize = 20;
/// `σ̇` across `s`, relative to the influence of `s`, at which the direction is known.
const RESIDUAL: f64 = 1e-14;

impl Multipliers {
    /// Solves for the directions of the unit vectors `leaving`, which are held, and writes the field for them; false if
    /// there is no solution.
    pub(crate) fn leave(
        &mut self,
        system: &mut impl Switched,
        (t, x): (f64, &[f64]),
        leaving: &[usize],
        dx: &mut [f64],
    ) -> bool {
        let all: Vec<usize> = leaving.iter().flat_map(|&i| self.parts[i].clone()).collect();
        if all.iter().any(|&c| !self.s[c].is_finite()) {
            for &c in &all {
                self.s[c] = 0.0;
            }
        }
        for &i in leaving {
            self.scale_down(i);
        }
        if !self.field(system, t, x, dx) {
            return false;
        }
        self.gradients(system, t, x);
        for &i in leaving {
            self.fill(i, dx);
        }
        let Some(jacobian) = self.influence_of(system, (t, x), &all, dx) else {
            return false;
        };
        let size = jacobian.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let mut turned: Vec<usize> = Vec::new();
        for iteration in 0..FIXED_POINT + NEWTON {
            if !self.field(system, t, x, dx) {
                return false;
            }
            self.gradients(system, t, x);
            let rates = DVector::from_iterator(all.len(), all.iter().map(|&c| self.rate(c, dx)));
            if !rates.iter().all(|r| r.is_finite()) {
                return false;
            }
            let mut across = rates.clone();
            let mut residual = 0.0f64;
            let mut first = 0;
            let mut radial = vec![0.0; all.len()];
            for &i in leaving {
                let rate = self.radial_rate(i, dx);
                let part = self.parts[i].clone();
                for (a, c) in part.enumerate() {
                    across[first + a] -= rate * self.s[c];
                    radial[first + a] = rate;
                    residual = residual.max(across[first + a].abs());
                }
                first += self.parts[i].len();
            }
            let known = RESIDUAL * size + 1e-15 * rates.amax();
            if residual <= known {
                // The way opposite to σ̇ is a fixed point too where `s` has no influence on its own σ̇: turn it round, once.
                let backwards = |i: &usize| !turned.contains(i) && self.radial_rate(*i, dx) < -known;
                let backwards: Vec<usize> = leaving.iter().copied().filter(backwards).collect();
                if backwards.is_empty() {
                    return true;
                }
                for &i in &backwards {
                    self.s[self.parts[i].clone()].iter_mut().for_each(|s| *s = -*s);
                }
                turned.extend(backwards);
                continue;
            }
            // Close to the solution: Newton's step within the sphere.
            let newton = residual < 1e-2 * size || iteration >= FIXED_POINT;
            let step = if newton { self.step_on_sphere(leaving, &jacobian, &across, &radial, size) } else { None };
            let mut first = 0;
            for &i in leaving {
                let part = self.parts[i].clone();
                for (a, c) in part.clone().enumerate() {
                    match &step {
                        Some(step) => self.s[c] += step[first + a],
                        None => self.s[c] = size * self.s[c] + rates[first + a],
                    }
                }
                let length = norm(&self.s[part.clone()]);
                if length == 0.0 || !length.is_finite() {
                    return false;
                }
                self.s[part.clone()].iter_mut().for_each(|s| *s /= length);
                first += part.len();
            }
        }
        false
    }

    /// The step of Newton's method for `P σ̇ = 0`: `(P J P − λ) δ = −P σ̇`, `P = 1 − s sᵀ`.
    fn step_on_sphere(
        &self,
        leaving: &[usize],
        jacobian: &DMatrix<f64>,
        across: &DVector<f64>,
        radial: &[f64],
        size: f64,
    ) -> Option<DVector<f64>> {
        let k = across.len();
        let mut projection = DMatrix::<f64>::identity(k, k);
        let mut along = DMatrix::<f64>::zeros(k, k);
        let mut first = 0;
        for &i in leaving {
            let part = self.parts[i].clone();
            for (a, c) in part.clone().enumerate() {
                for (b, d) in part.clone().enumerate() {
                    along[(first + a, first + b)] = self.s[c] * self.s[d];
                }
            }
            first += part.len();
        }
        projection -= &along;
        let mut matrix = &projection * jacobian * &projection - along * size.max(f64::MIN_POSITIVE);
        for a in 0..k {
            // Directions without influence follow σ̇ as slowly as |σ| grows.
            matrix[(a, a)] -= radial[a].max(0.0) + 1e-13 * size;
        }
        let step = matrix.lu().solve(&-across)?;
        step.iter().all(|v| v.is_finite() && v.abs() < 1.0).then_some(step)
    }

    /// `∂σ̇/∂s` for the components `all`, by unit differences; what sticks gives way as it would.
    pub(crate) fn influence_of(
        &mut self,
        system: &mut impl Switched,
        (t, x): (f64, &[f64]),
        all: &[usize],
        dx: &mut [f64],
    ) -> Option<DMatrix<f64>> {
        let k = all.len();
        let mut jacobian = DMatrix::zeros(k, k);
        if !self.field(system, t, x, dx) {
            return None;
        }
        self.gradients(system, t, x);
        let before: Vec<f64> = all.iter().map(|&c| self.rate(c, dx)).collect();
        let mut velocity = dx.to_vec();
        for (b, &d) in all.iter().enumerate() {
            let s = self.s[d];
            let step = if s > 0.0 { -1.0 } else { 1.0 };
            self.s[d] = s + step;
            let solved = self.field(system, t, x, &mut velocity);
            self.s[d] = s;
            if !solved {
                return None;
            }
            for (a, &c) in all.iter().enumerate() {
                jacobian[(a, b)] = (self.rate(c, &velocity) - before[a]) / step;
            }
        }
        jacobian.iter().all(|v: &f64| v.is_finite()).then_some(jacobian)
    }

    /// Brings a direction into the unit ball.
    fn scale_down(&mut self, switch: usize) {
        let size = self.size(switch).max(1.0);
        for c in self.parts[switch].clone() {
            self.s[c] /= size;
        }
    }

    /// Completes the direction of a switch to unit length along its `σ̇`.
    fn fill(&mut self, switch: usize, dx: &[f64]) {
        let part = self.parts[switch].clone();
        let rates: Vec<f64> = part.clone().map(|c| self.rate(c, dx)).collect();
        let rate = norm(&rates);
        let size = self.size(switch);
        let missing = 1.0 - size.powi(2);
        if rate == 0.0 || !rate.is_finite() {
            // Nothing tells where to: any direction, or the present one.
            if size > 0.0 {
                part.for_each(|c| self.s[c] /= size);
            } else {
                self.s[part.start] = 1.0;
            }
            return;
        }
        if missing <= 0.0 {
            return;
        }
        let along: f64 = part.clone().zip(&rates).map(|(c, r)| self.s[c] * r / rate).sum();
        let way = (along * along + missing).sqrt() - along;
        for (c, r) in part.zip(&rates) {
            self.s[c] += way * r / rate;
        }
    }
}
