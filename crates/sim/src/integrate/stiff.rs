//! Steps for stiff fields: the three-stage Radau IIA method of order 5, whose stages are solved for by Newton's method (Hairer and Wanner
//! 1996, section IV.8).
//!
//! With `Z` the stages less the start, the equations `Z = h A F(x + Z)` are multiplied by `(h A)⁻¹`, whose eigenvalues are one real
//! and two complex ones. In the basis `Z = T W` of its eigenvectors each iteration solves one system of `n` and one of `2n` unknowns.

use super::dense::{EMBEDDED, interpolate, node_weights, third_difference};
use super::newton::Newton;
use super::step::{Attempt, Control, RADAU_STAGES, Step};
use crate::friction::Field;
use crate::settings::SimulationSettings;
use bracketry_numerics::collocation::{RADAU_3_NODES as C, RADAU_3_TRANSFORMED as BASIS};

const ITERATIONS: usize = 7;
/// Where the iteration contracts faster than this, the Jacobian is good for the next step, too.
const FAST: f64 = 1e-3;
/// The stages less the start, in this combination, are `−h` times the derivative of the cubic through them at the start.
const SLOPE: [f64; 3] = [(-13.0 - 7.0 * ROOT_6) / 3.0, (-13.0 + 7.0 * ROOT_6) / 3.0, -1.0 / 3.0];
const ROOT_6: f64 = 2.449_489_742_783_178;

/// The tolerances of a step, from those of the states: the estimated error is that of a method of order 3, while the continuous
/// extension has order 4, and the end of the step order 5.
fn loosened(settings: &SimulationSettings) -> f64 {
    let wanted = settings.rtol.max(settings.atol);
    (wanted.powf(0.8) / wanted).max(1.0)
}

/// A step whose stages are sought.
struct Attempted<'a, 's> {
    step: &'a mut Step,
    field: &'a mut Field<'s>,
    newton: &'a mut Newton,
    settings: &'a SimulationSettings,
    h: f64,
    /// By how much the tolerances are larger than those of the settings.
    loosened: f64,
    /// The stages less the start, and the same in the basis of eigenvectors.
    z: [Vec<f64>; 3],
    w: [Vec<f64>; 3],
    point: Vec<f64>,
}

/// How an iteration ended.
enum Iterated {
    Converged,
    Failed,
    NonFinite,
}

/// The stages of a step of length `h`, its end, its continuous extension and its error.
pub(super) fn attempt(step: &mut Step, field: &mut Field<'_>, h: f64, control: Control<'_>) -> Attempt {
    let mut newton = std::mem::take(&mut step.newton);
    let n = step.x.len();
    let rows = || std::array::from_fn(|_| vec![0.0; n]);
    let settings = control.settings;
    let mut attempted = Attempted {
        loosened: loosened(settings),
        step: &mut *step,
        field,
        newton: &mut newton,
        settings,
        h,
        z: rows(),
        w: rows(),
        point: vec![0.0; n],
    };
    let outcome = match attempted.solve() {
        Iterated::Converged => attempted.finish(control),
        Iterated::Failed => Attempt::Unsolvable,
        Iterated::NonFinite => Attempt::NonFinite,
    };
    newton.rejected = !matches!(outcome, Attempt::Error(error) if error <= 1.0);
    step.newton = newton;
    outcome
}

impl Attempted<'_, '_> {
    /// Error allowed in a state between the start and the end.
    fn scale(&self, j: usize, end: f64) -> f64 {
        self.loosened * self.settings.scale(self.step.x[j].abs().max(end.abs()))
    }

    /// Solves for the stages, with a Jacobian of the present point where an older one does not do.
    fn solve(&mut self) -> Iterated {
        loop {
            if self.newton.jacobian.is_none() {
                self.newton.factored = None;
                if !self.differentiate() {
                    return Iterated::NonFinite;
                }
            }
            if self.newton.factored != Some(self.h) && !self.factorize() {
                return Iterated::Failed;
            }
            match self.iterate() {
                Iterated::Converged => return Iterated::Converged,
                failed if self.newton.current => return failed,
                _ => self.newton.jacobian = None,
            }
        }
    }

    /// The Jacobian at the present point: as the system knows it, or by differences where signs and directions follow the state.
    fn differentiate(&mut self) -> bool {
        let (n, t) = (self.step.x.len(), self.step.t);
        let mut jacobian = vec![0.0; n * n];
        self.field.s.copy_from_slice(&self.step.signs[0]);
        let fixed = self.field.modes.iter().all(|mode| mode.sign() != 0.0);
        let known = fixed && self.field.system.jacobian(t, &self.step.x, &self.step.signs[0], &mut jacobian);
        if known {
            self.newton.effort += 1.0 + 0.2 * n as f64;
        } else {
            jacobian.fill(0.0);
            self.point.copy_from_slice(&self.step.x);
            let floor = self.settings.atol / self.settings.rtol;
            for j in 0..n {
                let x = self.step.x[j];
                self.point[j] = x + f64::EPSILON.sqrt() * x.abs().max(floor);
                let by = self.point[j] - x;
                if !self.field.evaluate((t, &self.point), &mut self.w[0]) {
                    return false;
                }
                self.point[j] = x;
                for i in 0..n {
                    jacobian[i * n + j] = (self.w[0][i] - self.step.k[0][i]) / by;
                }
            }
            self.newton.effort += n as f64;
        }
        let scales: Vec<f64> = self.step.x.iter().map(|x| self.settings.scale(x.abs())).collect();
        let size = |i: usize, j: usize| jacobian[i * n + j].abs() * scales[j] / scales[i];
        let by_rows = (0..n).map(|i| (0..n).map(|j| size(i, j)).sum::<f64>()).fold(0.0, f64::max);
        let by_columns = (0..n).map(|j| (0..n).map(|i| size(i, j)).sum::<f64>()).fold(0.0, f64::max);
        self.newton.norm = by_rows.min(by_columns);
        let finite = jacobian.iter().all(|v| v.is_finite());
        self.newton.jacobian = finite.then_some(jacobian);
        self.newton.current = finite;
        finite
    }

    /// The factors of `μ/h − ∂f/∂x`; those of the complex `μ = α − iβ` as of the real matrix for real and imaginary parts.
    fn factorize(&mut self) -> bool {
        let Newton { jacobian, real, complex, factored, effort, .. } = &mut *self.newton;
        *factored = None;
        let Some(jacobian) = jacobian else { return false };
        let n = self.step.x.len();
        let (alpha, beta) = (BASIS.alpha / self.h, BASIS.beta / self.h);
        let matrix = real.matrix(n);
        matrix.iter_mut().zip(&*jacobian).for_each(|(m, v)| *m = -v);
        matrix.iter_mut().step_by(n + 1).for_each(|m| *m += BASIS.real / self.h);
        let matrix = complex.matrix(2 * n);
        matrix.fill(0.0);
        for (i, row) in jacobian.chunks_exact(n).enumerate() {
            for (half, other) in [(0, beta), (n, -beta)] {
                let at = (half + i) * 2 * n;
                matrix[at + half..at + half + n].iter_mut().zip(row).for_each(|(m, v)| *m = -v);
                matrix[at + half + i] += alpha;
                matrix[at + n - half + i] = other;
            }
        }
        *effort += 0.08 * (n * n) as f64;
        if !(real.factorize() && complex.factorize()) {
            return false;
        }
        *factored = Some(self.h);
        true
    }

    /// Guesses the stages: on the extension of the step before, if the motion goes on from there.
    fn guess(&mut self) {
        let n = self.step.x.len();
        if let Some(before) = self.newton.before_length {
            for (z, c) in self.z.iter_mut().zip(C) {
                interpolate(&self.newton.before, n, 1.0 + c * self.h / before, z);
                z.iter_mut().zip(&self.step.x).for_each(|(z, x)| *z -= x);
            }
        } else {
            self.z.iter_mut().for_each(|z| z.fill(0.0));
        }
        for (w, row) in self.w.iter_mut().zip(BASIS.inverse) {
            for (j, w) in w.iter_mut().enumerate() {
                *w = (0..3).map(|l| row[l] * self.z[l][j]).sum();
            }
        }
    }

    /// Newton's iteration for the stages.
    fn iterate(&mut self) -> Iterated {
        let n = self.step.x.len();
        self.guess();
        let tolerance = self.loosened * self.settings.rtol;
        let converged = (10.0 * f64::EPSILON / tolerance).max(tolerance.sqrt().min(0.03));
        let (mut real, mut complex) = (vec![0.0; n], vec![0.0; 2 * n]);
        let (mut before, mut rate): (Option<f64>, Option<f64>) = (None, None);
        for iteration in 0..ITERATIONS {
            match self.evaluate() {
                Iterated::Converged => {}
                failed => return failed,
            }
            self.newton.effort += 3.0 + 0.2 * n as f64;
            let f = [1, 2, 3].map(|stage| &self.step.k[RADAU_STAGES[stage]]);
            let transformed = |row: usize, j: usize| (0..3).map(|l| BASIS.inverse[row][l] * f[l][j]).sum::<f64>();
            let (alpha, beta) = (BASIS.alpha / self.h, BASIS.beta / self.h);
            for j in 0..n {
                let (u, v) = (self.w[1][j], self.w[2][j]);
                real[j] = transformed(0, j) - BASIS.real / self.h * self.w[0][j];
                complex[j] = transformed(1, j) - alpha * u - beta * v;
                complex[n + j] = transformed(2, j) - alpha * v + beta * u;
            }
            self.newton.real.solve(&mut real, 1);
            self.newton.complex.solve(&mut complex, 1);
            let mut sum = 0.0;
            for j in 0..n {
                let scale = self.scale(j, self.step.x[j]);
                sum += [real[j], complex[j], complex[n + j]].iter().map(|d| (d / scale).powi(2)).sum::<f64>();
            }
            let change = (sum / (3 * n).max(1) as f64).sqrt();
            if !change.is_finite() {
                return Iterated::NonFinite;
            }
            if let Some(before) = before.filter(|before: &f64| *before > 0.0) {
                let now = change / before;
                // What the iterations that are left could still do.
                let left = now.powi((ITERATIONS - iteration) as i32) / (1.0 - now) * change;
                if now >= 1.0 || left > converged {
                    return Iterated::Failed;
                }
                rate = Some(now);
            }
            for j in 0..n {
                self.w[0][j] += real[j];
                self.w[1][j] += complex[j];
                self.w[2][j] += complex[n + j];
                for (z, row) in self.z.iter_mut().zip(BASIS.matrix) {
                    z[j] = (0..3).map(|l| row[l] * self.w[l][j]).sum();
                }
            }
            if change == 0.0 || rate.is_some_and(|rate| rate / (1.0 - rate) * change < converged) {
                // A Jacobian that has become slow is found anew at the next point.
                self.newton.slow = iteration > 1 && rate.is_some_and(|rate| rate > FAST);
                return Iterated::Converged;
            }
            before = Some(change);
        }
        Iterated::Failed
    }

    /// The field at the stages.
    fn evaluate(&mut self) -> Iterated {
        for (i, (z, c)) in self.z.iter().zip(C).enumerate() {
            let stage = RADAU_STAGES[i + 1];
            for ((p, x), z) in self.point.iter_mut().zip(&self.step.x).zip(z) {
                *p = x + z;
            }
            if !self.field.evaluate((self.step.t + c * self.h, &self.point), &mut self.step.k[stage]) {
                let finite = self.point.iter().all(|v| v.is_finite());
                return if finite { Iterated::Failed } else { Iterated::NonFinite };
            }
            if !self.step.k[stage].iter().all(|v| v.is_finite()) {
                return Iterated::NonFinite;
            }
            self.step.signs[stage].copy_from_slice(&self.field.s);
        }
        Iterated::Converged
    }

    /// The end of the step, its continuous extension and its error.
    fn finish(&mut self, control: Control<'_>) -> Attempt {
        let n = self.step.x.len();
        for ((end, x), z) in self.step.end.iter_mut().zip(&self.step.x).zip(&self.z[2]) {
            *end = x + z;
        }
        if !self.field.evaluate((self.step.t + self.h, &self.step.end), &mut self.step.k[6]) {
            return Attempt::Unsolvable;
        }
        if !self.step.k[6].iter().all(|v| v.is_finite()) {
            return Attempt::NonFinite;
        }
        self.step.signs[6].copy_from_slice(&self.field.s);
        let mut error = self.filtered(&self.step.k[0]);
        let size = |error: &[f64]| -> f64 {
            let part = |j: usize| (error[j] / self.scale(j, self.step.end[j])).powi(2);
            ((0..n).map(part).sum::<f64>() / n.max(1) as f64).sqrt()
        };
        // What an error at the start does to a stiff field says nothing of the step.
        if self.newton.rejected && size(&error) > 1.0 {
            for ((p, x), e) in self.point.iter_mut().zip(&self.step.x).zip(&error) {
                *p = x + e;
            }
            self.field.s.copy_from_slice(&self.step.signs[0]);
            if self.field.evaluate((self.step.t, &self.point), &mut self.w[0]) {
                error = self.filtered(&self.w[0]);
            }
        }
        let bends = self.bends(&error);
        self.extend(&bends);
        // What is stiff follows the motion of the rest, also where the filter hides it.
        let of_state = |j: usize| error[j].abs().max(EMBEDDED * bends[j].abs()) / self.loosened;
        let of_sign = |c: usize| EMBEDDED * third_difference(RADAU_STAGES.map(|stage| self.step.signs[stage][c]));
        self.step.judge(self.field, control, of_state, of_sign)
    }

    /// The difference between a field at the start and the slope of the cubic there, filtered so that what is stiff does not count.
    fn filtered(&self, field: &[f64]) -> Vec<f64> {
        let slope = |j: usize| (0..3).map(|l| SLOPE[l] * self.z[l][j]).sum::<f64>() / self.h;
        let mut error: Vec<f64> = field.iter().enumerate().map(|(j, f)| f + slope(j)).collect();
        self.newton.real.solve(&mut error, 1);
        error
    }

    /// By how much the motion differs from the cubic through the start and the stages, in units of `θ (θ − c₁) (θ − c₂) (θ − 1)`: so that
    /// the extension also goes through the start of the step before or, without one, has the filtered slope at the start.
    fn bends(&self, error: &[f64]) -> Vec<f64> {
        let Some(before) = self.newton.before_length else {
            return error.iter().map(|e| -10.0 * BASIS.real * e).collect();
        };
        let theta = -before / self.h;
        let product = theta * (theta - C[0]) * (theta - C[1]) * (theta - 1.0);
        let weights = node_weights(theta);
        let cubic = |j: usize| (0..3).map(|l| weights[l + 1] * self.z[l][j]).sum::<f64>();
        let bend = |j: usize| (self.newton.before[j] - self.step.x[j] - cubic(j)) / product;
        (0..self.step.x.len()).map(bend).collect()
    }

    /// The continuous extension: the cubic through the start and the stages, bent.
    fn extend(&mut self, bends: &[f64]) {
        let n = self.step.x.len();
        let coefficients = &mut self.step.coefficients;
        for j in 0..n {
            let last = self.z[2][j];
            let part = |i: usize| (self.z[i][j] - C[i] * last) / (C[i] * (1.0 - C[i]));
            let (first, second) = (part(0), part(1));
            let third = (second - first) / (C[1] - C[0]);
            let bend = 0.1 * bends[j];
            coefficients[j] = self.step.x[j];
            coefficients[n + j] = last;
            coefficients[2 * n + j] = first - C[0] * third - bend;
            coefficients[3 * n + j] = third - 2.0 * bend;
            coefficients[4 * n + j] = 10.0 * bend;
        }
    }
}
