//! Collocation: the stage increments Z_i = X_i − x solve Z_i = h Σ_j a_ij f(t + c_j h, x + Z_j, u).
//!
//! Newton's method with the exact Jacobian, damped, starts from Z = 0. The sensitivities come
//! from the implicit function theorem at its solution: (I − h A⊗J) dZ = h A⊗(J S + \[0 B\]).

use super::interval::Interval;
use super::one_step::{Differentiated, OneStepMethod, set_identity};
use super::stages::Stages;
use crate::dynamics::Dynamics;
use bracketry_numerics::collocation::Tableau;
use bracketry_numerics::dense::Lu;

/// Newton iterations after which a step has failed.
const MAX_ITERATIONS: usize = 50;
/// Largest correction relative to the state at which the stages count as solved.
const TOLERANCE: f64 = 1e-13;
/// Corrections at or below this size, relative to the state, may be rounding errors.
const ROUNDING: f64 = 1e-9;
/// Fraction of a correction below which the iteration has failed. Stiff reactions start with components that are smaller than
/// the others by many orders, and so is the share of the first correction that lowers the next one.
const SHORTEST: f64 = 1e-9;

/// The method with its working memory.
#[derive(Clone, Debug)]
pub(crate) struct Collocation {
    n: usize,
    m: usize,
    pattern: Vec<(usize, usize)>,
    tableau: Tableau,
    /// b A⁻¹: the end state is x + Σ d_i Z_i.
    end: Vec<f64>,
    z: Vec<f64>,
    start: Vec<f64>,
    residual: Vec<f64>,
    correction: Vec<f64>,
    field: Vec<f64>,
    jacobian: Vec<f64>,
    point: Vec<f64>,
    factors: Lu,
    /// dZ, s·n rows of n + m entries.
    dz: Vec<f64>,
    /// J S + \[0 B\], likewise.
    ds: Vec<f64>,
    s: Vec<f64>,
}

impl Collocation {
    pub(crate) fn new(n: usize, m: usize, pattern: &[(usize, usize)], tableau: Tableau) -> Self {
        let s = tableau.stages();
        let mut factors = Lu::default();
        let a = factors.matrix(s);
        a.copy_from_slice(&tableau.a);
        let mut end = tableau.b.clone();
        if factors.factorize() {
            factors.solve_transposed(&mut end);
        }
        let (rows, block) = (s * n, s * n * (n + m));
        Self {
            n,
            m,
            end,
            z: vec![0.0; rows],
            start: vec![0.0; rows],
            residual: vec![0.0; rows],
            correction: vec![0.0; rows],
            field: vec![0.0; rows],
            jacobian: vec![0.0; s * pattern.len()],
            pattern: pattern.to_vec(),
            point: vec![0.0; n],
            factors,
            dz: vec![0.0; block],
            ds: vec![0.0; block],
            s: vec![0.0; n * (n + m)],
            tableau,
        }
    }
}

impl OneStepMethod for Collocation {
    fn advance(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, x: &mut [f64]) -> bool {
        for time in interval.times() {
            if !self.solve(dynamics, time, x, interval.u, interval.step()) {
                x.fill(f64::NAN);
                return false;
            }
            self.finish(x);
        }
        true
    }

    fn differentiate(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, to: Differentiated<'_>) -> bool {
        let Differentiated { x, jacobian, mut stages } = to;
        let (n, w) = (self.n, self.n + self.m);
        let (h, u) = (interval.step(), interval.u);
        set_identity(&mut self.s, w);
        for time in interval.times() {
            if !(self.solve(dynamics, time, x, u, h) && self.linearize(dynamics, time, x, u, h)) {
                x.fill(f64::NAN);
                jacobian.fill(f64::NAN);
                return false;
            }
            self.stage_sensitivities(h);
            if let Some(stages) = &mut stages {
                self.note(time, x, h, stages);
            }
            for (q, d) in self.end.iter().enumerate() {
                for e in 0..n * w {
                    self.s[e] += d * self.dz[q * n * w + e];
                }
            }
            self.finish(x);
        }
        jacobian.copy_from_slice(&self.s);
        true
    }

    /// With (I − h A⊗J)ᵀ w = d⊗λ they are h Σ_p a_pq w_p.
    fn adjoints(&mut self, h: f64, stages: &mut Stages, lambda: &mut [f64]) {
        let (n, s) = (self.n, self.tableau.stages());
        stages.weights.resize(stages.times.len() * n, 0.0);
        for step in (0..stages.times.len() / s).rev() {
            let block = self.jacobian.len();
            self.jacobian.copy_from_slice(&stages.jacobians[step * block..(step + 1) * block]);
            self.factorize(h);
            for (p, d) in self.end.iter().enumerate() {
                for i in 0..n {
                    self.residual[p * n + i] = d * lambda[i];
                }
            }
            self.factors.solve_transposed(&mut self.residual);
            for q in 0..s {
                let at = step * s + q;
                for i in 0..n {
                    let sum: f64 = (0..s).map(|p| self.tableau.a[p * s + q] * self.residual[p * n + i]).sum();
                    stages.weights[at * n + i] = h * sum;
                }
                stages.add_transposed(&self.pattern, at, lambda);
            }
        }
    }
}

impl Collocation {
    fn note(&mut self, time: f64, x: &[f64], h: f64, stages: &mut Stages) {
        let (n, block, entries) = (self.n, self.n * (self.n + self.m), self.pattern.len());
        for (q, c) in self.tableau.c.iter().enumerate() {
            for i in 0..n {
                self.point[i] = x[i] + self.z[q * n + i];
            }
            let sensitivity = self.s.iter().zip(&self.dz[q * block..(q + 1) * block]).map(|(s, d)| s + d);
            stages.push(time + c * h, &self.point, &self.jacobian[q * entries..(q + 1) * entries], sensitivity);
        }
    }

    fn finish(&self, x: &mut [f64]) {
        for (q, d) in self.end.iter().enumerate() {
            for i in 0..self.n {
                x[i] += d * self.z[q * self.n + i];
            }
        }
    }

    /// Newton's method for the stages of one step, damped by the natural monotonicity test (Deuflhard 2004, section 3.3): the
    /// next correction, with the same Jacobian, must become smaller.
    fn solve(&mut self, dynamics: &mut dyn Dynamics, t: f64, x: &[f64], u: &[f64], h: f64) -> bool {
        let size = x.iter().fold(1e-6, |m: f64, v| m.max(v.abs()));
        let largest =
            |v: &[f64]| v.iter().fold(0.0, |m: f64, v| if v.is_nan() { f64::INFINITY } else { m.max(v.abs()) });
        self.z.fill(0.0);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            if !self.linearize(dynamics, t, x, u, h) {
                return false;
            }
            self.residual(h);
            self.factors.solve(&mut self.residual, 1);
            std::mem::swap(&mut self.correction, &mut self.residual);
            let correction = largest(&self.correction);
            if !correction.is_finite() {
                return false;
            }
            let mut alpha = 1.0;
            std::mem::swap(&mut self.z, &mut self.start);
            loop {
                for (z, (o, d)) in self.z.iter_mut().zip(self.start.iter().zip(&self.correction)) {
                    *z = o - alpha * d;
                }
                // At rounding level nothing falls any more; a correction that small is harmless.
                if correction <= ROUNDING * size {
                    break;
                }
                self.fields(dynamics, t, x, u, h);
                self.residual(h);
                self.factors.solve(&mut self.residual, 1);
                if largest(&self.residual) <= (1.0 - alpha / 4.0) * correction {
                    break;
                }
                alpha /= 2.0;
                if alpha < SHORTEST {
                    return false;
                }
            }
            // The second condition: rounding keeps the corrections from shrinking further.
            if correction <= TOLERANCE * size || (correction <= ROUNDING * size && correction > 0.5 * last) {
                return true;
            }
            last = correction;
        }
        false
    }

    /// The field at the stages.
    fn fields(&mut self, dynamics: &mut dyn Dynamics, t: f64, x: &[f64], u: &[f64], h: f64) {
        let n = self.n;
        for (q, c) in self.tableau.c.iter().enumerate() {
            for i in 0..n {
                self.point[i] = x[i] + self.z[q * n + i];
            }
            dynamics.field(t + c * h, &self.point, u, &mut self.field[q * n..(q + 1) * n]);
        }
    }

    /// Z_i − h Σ a_ij f(X_j) from the field at the stages.
    fn residual(&mut self, h: f64) {
        let (n, s) = (self.n, self.tableau.stages());
        for p in 0..s {
            for i in 0..n {
                let sum: f64 = (0..s).map(|q| self.tableau.a[p * s + q] * self.field[q * n + i]).sum();
                self.residual[p * n + i] = self.z[p * n + i] - h * sum;
            }
        }
    }

    /// Jacobians at the stages and the factors of I − h A⊗J.
    fn linearize(&mut self, dynamics: &mut dyn Dynamics, t: f64, x: &[f64], u: &[f64], h: f64) -> bool {
        let (n, s) = (self.n, self.tableau.stages());
        let entries = dynamics.jacobian_pattern().len();
        for q in 0..s {
            for i in 0..n {
                self.point[i] = x[i] + self.z[q * n + i];
            }
            dynamics.field_and_jacobian(
                t + self.tableau.c[q] * h,
                &self.point,
                u,
                &mut self.field[q * n..(q + 1) * n],
                &mut self.jacobian[q * entries..(q + 1) * entries],
            );
        }
        self.factorize(h)
    }

    /// The factors of I − h A⊗J from the Jacobians at the stages.
    fn factorize(&mut self, h: f64) -> bool {
        let (n, s, entries) = (self.n, self.tableau.stages(), self.pattern.len());
        let size = s * n;
        let matrix = self.factors.matrix(size);
        matrix.fill(0.0);
        for i in 0..size {
            matrix[i * size + i] = 1.0;
        }
        for (e, &(i, j)) in self.pattern.iter().enumerate() {
            if j < n {
                for p in 0..s {
                    for q in 0..s {
                        matrix[(p * n + i) * size + q * n + j] -=
                            h * self.tableau.a[p * s + q] * self.jacobian[q * entries + e];
                    }
                }
            }
        }
        self.factors.factorize()
    }

    /// dZ from the sensitivities S at the start of the step.
    fn stage_sensitivities(&mut self, h: f64) {
        let (n, w, s) = (self.n, self.n + self.m, self.tableau.stages());
        self.ds.fill(0.0);
        for q in 0..s {
            let block = &mut self.ds[q * n * w..(q + 1) * n * w];
            for (e, &(i, j)) in self.pattern.iter().enumerate() {
                let v = self.jacobian[q * self.pattern.len() + e];
                if j < n {
                    for c in 0..w {
                        block[i * w + c] += v * self.s[j * w + c];
                    }
                } else {
                    block[i * w + j] += v;
                }
            }
        }
        for p in 0..s {
            for e in 0..n * w {
                let sum: f64 = (0..s).map(|q| self.tableau.a[p * s + q] * self.ds[q * n * w + e]).sum();
                self.dz[p * n * w + e] = h * sum;
            }
        }
        self.factors.solve(&mut self.dz, w);
    }
}
