//! Sticking signs of systems that are affine in them: one evaluation and one small linear solve.

use crate::Switched;
use crate::elimination::{eliminate, is_idle};
use crate::multipliers::Multipliers;

/// Pivots below this part of the largest entry mean redundant switches.
const SINGULAR: f64 = 1e-10;

impl Multipliers {
    /// Writes `f(t, x, s)` with the sticking signs solved for, by the gradients of this point. False if the system is not
    /// affine in its signs, or if they do not determine each other: then nothing is changed but `dx`.
    pub(crate) fn solve_affine(&mut self, system: &mut impl Switched, t: f64, x: &[f64], dx: &mut [f64]) -> bool {
        if !system.affine(t, x, &self.s, dx, &mut self.by_sign) {
            return false;
        }
        self.evaluations += 1;
        let m = self.sticking.len();
        let n = self.n;
        let mut size = 0.0f64;
        for a in 0..m {
            let i = self.sticking[a];
            let row = &self.gradient[i * n..(i + 1) * n];
            let mut influence = 0.0;
            for b in 0..m {
                let j = self.sticking[b];
                let column = &self.by_sign[j * n..(j + 1) * n];
                let entry: f64 = row.iter().zip(column).map(|(g, v)| g * v).sum();
                self.matrix[a * m + b] = entry;
                influence += entry.abs();
            }
            self.influence[a] = influence;
            size = size.max(influence);
            self.delta[a] = -self.rate(i, dx);
        }
        if !eliminate(&mut self.matrix[..m * m], &mut self.delta[..m], m, SINGULAR * size) {
            return false;
        }
        for a in 0..m {
            let j = self.sticking[a];
            if is_idle(&self.matrix, m, a) {
                // A component that moves nothing takes no part of what the others may resist.
                self.delta[a] = -self.s[j];
            }
            self.s[j] += self.delta[a];
            for (d, v) in dx.iter_mut().zip(&self.by_sign[j * n..(j + 1) * n]) {
                *d += self.delta[a] * v;
            }
        }
        true
    }
}
