//! Steps for unit vectors near σ = 0, where the direction is attracted at the rate `|∂σ̇/∂s|/|σ|` and explicit steps crawl.
//!
//! The three-stage Radau IIA method (Hairer, Wanner, *Solving Ordinary Differential Equations II*, 2nd ed., section IV.8; order 5,
//! stiffly accurate) with the directions of the stages as unknowns: `|σ(t_i, X_i)| s_i = σ(t_i, X_i)`. Written so, the
//! equations stay well conditioned down to `σ = 0`, from where a unit vector starts when it breaks loose.

use crate::multipliers::norm;
use crate::stages::Attempt;
use crate::stepper::Stepper;
use crate::{Mode, Switched};
use nalgebra::{DMatrix, DVector};

const ROOT6: f64 = 2.449_489_742_783_178;
/// Nodes of the stages.
const C: [f64; 3] = [(4.0 - ROOT6) / 10.0, (4.0 + ROOT6) / 10.0, 1.0];
const A: [[f64; 3]; 3] = [
    [(88.0 - 7.0 * ROOT6) / 360.0, (296.0 - 169.0 * ROOT6) / 1800.0, (-2.0 + 3.0 * ROOT6) / 225.0],
    [(296.0 + 169.0 * ROOT6) / 1800.0, (88.0 + 7.0 * ROOT6) / 360.0, (-2.0 - 3.0 * ROOT6) / 225.0],
    [(16.0 - ROOT6) / 36.0, (16.0 + ROOT6) / 36.0, 1.0 / 9.0],
];
/// Where the fields of the start and the stages are kept among the stages of the explicit method.
pub(crate) const SLOTS: [usize; 4] = [0, 1, 2, 6];
/// The embedded third-order error (Hairer and Wanner's, without their filter) is this times the third divided difference
/// of the field.
const EMBEDDED: f64 = 0.0275;
const ITERATIONS: usize = 15;
/// Change of the stages from one iteration to the next, relative to the tolerance.
const CONVERGED: f64 = 1e-3;
/// Explicit steps are stable to 3.3 times `|σ|/|∂σ̇/∂s|`.
const STIFF: f64 = 2.0;
/// Steps for which a measured influence is trusted.
const TRUSTED: usize = 16;

impl<S: Switched> Stepper<S> {
    /// Whether a step of length `h` from the current point has to be implicit.
    pub(crate) fn is_stiff(&mut self, h: f64) -> bool {
        if (0..self.modes.len()).any(|i| self.modes[i] == Mode::Sliding && self.departing[i]) {
            return true;
        }
        if self.nearest.is_infinite() {
            return false;
        }
        let now = self.statistics.steps + self.statistics.rejected;
        if self.influence_at.is_none_or(|at| now > at + TRUSTED) {
            let size = self.influence().map_or(0.0, |m| m.amax());
            self.influence_size = size;
            self.influence_at = Some(now);
        }
        let limit = if self.implicit { 0.5 * STIFF } else { STIFF };
        h * self.influence_size > limit * self.nearest
    }

    /// The sliding unit vectors' `∂σ̇/∂s` at the current point.
    fn influence(&mut self) -> Option<DMatrix<f64>> {
        let sliding = self.sliding();
        let all: Vec<usize> = sliding.iter().flat_map(|&i| self.multipliers.parts[i].clone()).collect();
        self.multipliers.s.copy_from_slice(&self.signs[0]);
        for &i in &sliding {
            self.multipliers.held[i] = true;
        }
        let influence = self.multipliers.influence_of(&mut self.system, (self.t, &self.x), &all, &mut self.stage);
        self.multipliers.held.fill(false);
        influence
    }

    fn sliding(&self) -> Vec<usize> {
        (0..self.modes.len()).filter(|&i| self.modes[i] == Mode::Sliding).collect()
    }

    /// The stages of an implicit step of length `h`, its end, its continuous extension and its error, as
    /// [`Stepper::attempt`].
    pub(crate) fn attempt_implicit(&mut self, h: f64, control_signs: bool) -> Attempt {
        let Some(influence) = self.influence() else {
            return Attempt::Unsolvable;
        };
        let sliding = self.sliding();
        for &i in &sliding {
            self.multipliers.held[i] = true;
        }
        let solved = self.solve_stages(h, &sliding, &influence);
        self.multipliers.held.fill(false);
        match solved {
            Some(true) => {}
            Some(false) => return Attempt::Unsolvable,
            None => return Attempt::NonFinite,
        }
        self.extend_implicit(h);
        let mut error = self.embedded_error(h);
        if control_signs {
            error = error.max(self.sign_error());
        }
        if error.is_nan() { Attempt::NonFinite } else { Attempt::Error(error) }
    }

    /// Solves for the directions of all stages; false if the iteration fails, none if something is not finite.
    fn solve_stages(&mut self, h: f64, sliding: &[usize], influence: &DMatrix<f64>) -> Option<bool> {
        let n = self.x.len();
        for stage in 1..4 {
            let (first, later) = self.k.split_at_mut(1);
            later[SLOTS[stage] - 1].copy_from_slice(&first[0]);
            let (first, later) = self.signs.split_at_mut(1);
            later[SLOTS[stage] - 1].copy_from_slice(&first[0]);
        }
        let mut points = vec![vec![0.0; n]; 3];
        for iteration in 0..ITERATIONS {
            let mut change = 0.0f64;
            for i in 0..3 {
                for j in 0..n {
                    let sum: f64 = (0..3).map(|l| A[i][l] * self.k[SLOTS[l + 1]][j]).sum();
                    let value = self.x[j] + h * sum;
                    // Loose tolerances leave no room for an iteration that is loose, too.
                    let scale = self.settings.atol.min(1e-9) + self.settings.rtol.min(1e-9) * value.abs();
                    change = change.max((value - points[i][j]).abs() / scale);
                    points[i][j] = value;
                }
            }
            if change.is_nan() {
                return None;
            }
            if iteration > 1 && change <= CONVERGED {
                self.end.copy_from_slice(&points[2]);
                return Some(self.all_forward(h, sliding, &points));
            }
            if !self.turn_directions(h, sliding, influence, &points) {
                return Some(false);
            }
            for i in 0..3 {
                let slot = SLOTS[i + 1];
                self.multipliers.s.copy_from_slice(&self.signs[slot]);
                let t = self.t + C[i] * h;
                if !self.multipliers.field(&mut self.system, t, &points[i], &mut self.k[slot]) {
                    return points[i].iter().all(|v| v.is_finite()).then_some(false);
                }
                self.signs[slot].copy_from_slice(&self.multipliers.s);
                if !self.k[slot].iter().all(|v| v.is_finite()) {
                    return None;
                }
            }
        }
        Some(false)
    }

    /// Whether σ points along its direction at every stage.
    fn all_forward(&mut self, h: f64, sliding: &[usize], points: &[Vec<f64>]) -> bool {
        for (i, point) in points.iter().enumerate() {
            self.system.switching(self.t + C[i] * h, point, &mut self.sigma);
            let s = &self.signs[SLOTS[i + 1]];
            for &switch in sliding {
                let along: f64 = self.multipliers.parts[switch].clone().map(|c| s[c] * self.sigma[c]).sum();
                if along < 0.0 {
                    return false;
                }
            }
        }
        true
    }

    /// Newton's step for `Q_iᵀ σ(X_i) = 0` in the directions of all stages, where the columns of `Q_i` span what is normal to
    /// them; false if there is no such step.
    fn turn_directions(&mut self, h: f64, sliding: &[usize], influence: &DMatrix<f64>, points: &[Vec<f64>]) -> bool {
        let size = influence.amax();
        let (mut turning, mut following, mut unknowns, mut first) = (Vec::new(), Vec::new(), 0, 0);
        for &switch in sliding {
            let part = self.multipliers.parts[switch].clone();
            let rows = first..first + part.len();
            first = rows.end;
            if influence.rows_range(rows.clone()).amax() == 0.0 {
                following.push(part);
            } else {
                unknowns += part.len() - 1;
                turning.push((rows, part));
            }
        }
        let mut normals = DMatrix::zeros(influence.nrows(), 3 * unknowns);
        let mut right = DVector::zeros(3 * unknowns);
        let mut lengths = DVector::zeros(3 * unknowns);
        for (i, point) in points.iter().enumerate() {
            self.system.switching(self.t + C[i] * h, point, &mut self.sigma);
            let s = &mut self.signs[SLOTS[i + 1]];
            for part in &following {
                // Nothing to solve for: the direction follows σ.
                let length = norm(&self.sigma[part.clone()]);
                for c in part.clone().filter(|_| length > 0.0) {
                    s[c] = self.sigma[c] / length;
                }
            }
            let mut column = i * unknowns;
            for (rows, part) in &turning {
                let (s, sigma) = (&s[part.clone()], &self.sigma[part.clone()]);
                let along: f64 = s.iter().zip(sigma).map(|(s, v)| s * v).sum();
                for normal in normals_to(s) {
                    for (row, v) in rows.clone().zip(normal) {
                        normals[(row, column)] = v;
                        right[column] -= v * sigma[row - rows.start];
                    }
                    lengths[column] = along.max(0.0) + 1e-6 * h * size;
                    column += 1;
                }
            }
        }
        if unknowns == 0 {
            return true;
        }
        let mut matrix = normals.tr_mul(&(influence * &normals));
        for i in 0..3 {
            for j in 0..3 {
                let mut block = matrix.view_mut((i * unknowns, j * unknowns), (unknowns, unknowns));
                block *= h * A[i][j];
            }
        }
        for (a, length) in lengths.iter().enumerate() {
            matrix[(a, a)] -= length;
        }
        let Some(turn) = matrix.lu().solve(&right).filter(|turn| turn.iter().all(|v| v.is_finite())) else {
            return false;
        };
        let steps: [DVector<f64>; 3] =
            std::array::from_fn(|i| normals.columns(i * unknowns, unknowns) * turn.rows(i * unknowns, unknowns));
        let shorten = (0.7 / steps.iter().fold(0.0f64, |largest, step| largest.max(step.amax()))).min(1.0);
        for (i, step) in steps.iter().enumerate() {
            let s = &mut self.signs[SLOTS[i + 1]];
            for (rows, part) in &turning {
                for (c, row) in part.clone().zip(rows.clone()) {
                    s[c] += shorten * step[row];
                }
                let length = norm(&s[part.clone()]);
                s[part.clone()].iter_mut().for_each(|v| *v /= length);
            }
        }
        true
    }

    /// The polynomial of degree 4 with the field of the start and of all stages as derivatives.
    fn extend_implicit(&mut self, h: f64) {
        let n = self.x.len();
        let c = C[0];
        for j in 0..n {
            let difference = self.end[j] - self.x[j];
            let bend = h * self.k[0][j] - difference;
            let third = difference - h * self.k[6][j] - bend;
            let slope = difference + (1.0 - 2.0 * c) * bend + c * (2.0 - 3.0 * c) * third;
            self.coefficients[j] = self.x[j];
            self.coefficients[n + j] = difference;
            self.coefficients[2 * n + j] = bend;
            self.coefficients[3 * n + j] = third;
            self.coefficients[4 * n + j] = (h * self.k[1][j] - slope) / (2.0 * c * (1.0 - c) * (1.0 - 2.0 * c));
        }
    }

    fn embedded_error(&self, h: f64) -> f64 {
        let n = self.x.len();
        let mut sum = 0.0;
        for j in 0..n {
            let scale = self.settings.atol + self.settings.rtol * self.x[j].abs().max(self.end[j].abs());
            let e = EMBEDDED * h * third_difference(std::array::from_fn(|i| self.k[SLOTS[i]][j])) / scale;
            sum += e * e;
        }
        (sum / n.max(1) as f64).sqrt()
    }

    /// The error of the sticking signs, as of the explicit method.
    fn sign_error(&self) -> f64 {
        let mut error = 0.0f64;
        for (part, mode) in self.multipliers.parts.iter().zip(&self.modes) {
            if *mode == Mode::Sticking {
                for c in part.clone() {
                    let e = EMBEDDED * third_difference(std::array::from_fn(|i| self.signs[SLOTS[i]][c]));
                    error = error.max(e.abs() / crate::stages::SIGN_TOLERANCE);
                }
            }
        }
        error
    }

    /// Within the last implicit step, at fraction `theta`: holds the directions at their interpolated values.
    pub(crate) fn interpolate_directions(&mut self, theta: f64) {
        let weights = node_weights(theta);
        for i in self.sliding() {
            let part = self.multipliers.parts[i].clone();
            for c in part.clone() {
                self.multipliers.s[c] = (0..4).map(|l| weights[l] * self.signs[SLOTS[l]][c]).sum();
            }
            let length = norm(&self.multipliers.s[part.clone()]);
            self.multipliers.s[part].iter_mut().for_each(|v| *v /= length);
            self.multipliers.held[i] = true;
        }
    }
}

/// An orthonormal basis of what is normal to a unit vector: Householder's reflection of its largest component, without
/// the column of that.
fn normals_to(s: &[f64]) -> impl Iterator<Item = impl Iterator<Item = f64>> {
    let largest = (1..s.len()).fold(0, |m, c| if s[c].abs() > s[m].abs() { c } else { m });
    let mirror = move |c: usize| if c == largest { s[c] + s[c].signum() } else { s[c] };
    let denominator = 1.0 + s[largest].abs();
    (0..s.len())
        .filter(move |&b| b != largest)
        .map(move |b| (0..s.len()).map(move |a| f64::from(u8::from(a == b)) - mirror(a) * mirror(b) / denominator))
}

/// Lagrange's weights at `theta` for the start and the nodes of a step.
pub(crate) fn node_weights(theta: f64) -> [f64; 4] {
    let nodes = [0.0, C[0], C[1], C[2]];
    std::array::from_fn(|i| (0..4).filter(|&l| l != i).map(|l| (theta - nodes[l]) / (nodes[i] - nodes[l])).product())
}

/// Third divided difference over the start and the nodes.
fn third_difference(f: [f64; 4]) -> f64 {
    let nodes = [0.0, C[0], C[1], C[2]];
    (0..4).map(|i| f[i] / (0..4).filter(|&l| l != i).map(|l| nodes[i] - nodes[l]).product::<f64>()).sum()
}
