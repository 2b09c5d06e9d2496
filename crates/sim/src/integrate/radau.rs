//! Steps for unit vectors near σ = 0, where the direction is attracted at the rate `|∂σ̇/∂s|/|σ|` and explicit steps crawl.
//!
//! The three-stage Radau IIA method (Hairer and Wanner 1996, section IV.8; order 5,
//! stiffly accurate) with the directions of the stages as unknowns: `|σ(t_i, X_i)| s_i = σ(t_i, X_i)`. Written so, the
//! equations stay well conditioned down to `σ = 0`, from where a unit vector starts when it breaks loose.

use super::dense::{EMBEDDED, third_difference};
use super::step::{Attempt, Control, RADAU_STAGES, Step};
use crate::friction::{Field, FrictionMode, divide, norm};
use bracketry_numerics::collocation::{RADAU_3 as A, RADAU_3_NODES as C};
use bracketry_numerics::linear_equations::solve_vector;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

const ITERATIONS: usize = 15;
/// Change of the stages from one iteration to the next, relative to the tolerance.
const CONVERGED: f64 = 1e-3;

/// The equations of the stages.
struct Stages<'a, 's> {
    step: &'a mut Step,
    field: &'a mut Field<'s>,
    h: f64,
    /// Tolerances of the iteration, absolute and relative: loose ones leave no room for an iteration that is loose, too.
    tolerances: (f64, f64),
    /// The unit vectors that slide.
    sliding: Vec<usize>,
    /// Their `∂σ̇/∂s` at the start.
    influence: DMatrix<f64>,
}

/// The unit vectors whose directions are solved for: rows of the influence, and components.
type Turning = Vec<(Range<usize>, Range<usize>)>;

/// The stages of a step of length `h`, its end, its continuous extension and its error.
pub(super) fn attempt(step: &mut Step, field: &mut Field<'_>, h: f64, control: Control<'_>) -> Attempt {
    let Some(influence) = field.influence_of_directions((step.t, &step.x), &step.signs[0]) else {
        return Attempt::Unsolvable;
    };
    let sliding: Vec<usize> = field.in_mode(FrictionMode::Sliding).collect();
    field.hold_directions(sliding.iter().copied());
    let tolerances = (control.settings.atol.min(1e-9), control.settings.rtol.min(1e-9));
    let solved = Stages { step, field, h, tolerances, sliding, influence }.solve();
    field.release_directions();
    match solved {
        Some(true) => {}
        Some(false) => return Attempt::Unsolvable,
        None => return Attempt::NonFinite,
    }
    // The polynomial of degree 4 with the field of the start and of all stages as derivatives.
    let c = C[0];
    step.extend(h, |k, j, [difference, bend, third]| {
        let slope = difference + (1.0 - 2.0 * c) * bend + c * (2.0 - 3.0 * c) * third;
        (h * k[1][j] - slope) / (2.0 * c * (1.0 - c) * (1.0 - 2.0 * c))
    });
    let difference = |of: &[Vec<f64>; 7], j: usize| third_difference(RADAU_STAGES.map(|stage| of[stage][j]));
    let of_state = |j: usize| EMBEDDED * h * difference(&step.k, j);
    let of_sign = |c: usize| EMBEDDED * difference(&step.signs, c);
    step.judge(field, control, of_state, of_sign)
}

impl Stages<'_, '_> {
    /// Solves for the directions of all stages; false if the iteration fails, none if something is not finite.
    fn solve(&mut self) -> Option<bool> {
        let n = self.step.x.len();
        for stage in 1..4 {
            for of in [&mut self.step.k, &mut self.step.signs] {
                let (first, later) = of.split_at_mut(1);
                later[RADAU_STAGES[stage] - 1].copy_from_slice(&first[0]);
            }
        }
        let mut points = vec![vec![0.0; n]; 3];
        for iteration in 0..ITERATIONS {
            let change = self.update(&mut points);
            if change.is_nan() {
                return None;
            }
            if iteration > 1 && change <= CONVERGED {
                self.step.end.copy_from_slice(&points[2]);
                return Some(self.all_forward(&points));
            }
            if !self.turn_directions(&points) {
                return Some(false);
            }
            for (i, point) in points.iter().enumerate() {
                let (stage, t) = (RADAU_STAGES[i + 1], self.step.t + C[i] * self.h);
                self.field.s.copy_from_slice(&self.step.signs[stage]);
                if !self.field.evaluate((t, point), &mut self.step.k[stage]) {
                    return point.iter().all(|v| v.is_finite()).then_some(false);
                }
                self.step.signs[stage].copy_from_slice(&self.field.s);
                if !self.step.k[stage].iter().all(|v| v.is_finite()) {
                    return None;
                }
            }
        }
        Some(false)
    }

    /// The states of the stages by their fields; the largest change, scaled.
    fn update(&self, points: &mut [Vec<f64>]) -> f64 {
        let (atol, rtol) = self.tolerances;
        let mut change = 0.0f64;
        for (i, point) in points.iter_mut().enumerate() {
            for (j, x) in point.iter_mut().enumerate() {
                let sum: f64 = (0..3).map(|l| A[i][l] * self.step.k[RADAU_STAGES[l + 1]][j]).sum();
                let value = self.step.x[j] + self.h * sum;
                change = change.max((value - *x).abs() / (atol + rtol * value.abs()));
                *x = value;
            }
        }
        change
    }

    /// Evaluates σ at a stage; the directions there.
    fn surfaces_at(&mut self, stage: usize, point: &[f64]) -> &mut [f64] {
        let t = self.step.t + C[stage] * self.h;
        self.field.surfaces.evaluate(&mut self.field.system, t, point);
        &mut self.step.signs[RADAU_STAGES[stage + 1]]
    }

    /// Whether σ points along its direction at every stage.
    fn all_forward(&mut self, points: &[Vec<f64>]) -> bool {
        for (i, point) in points.iter().enumerate() {
            self.surfaces_at(i, point);
            let (s, surfaces) = (&self.step.signs[RADAU_STAGES[i + 1]], &self.field.surfaces);
            let along = |part: Range<usize>| part.map(|c| s[c] * surfaces.sigma[c]).sum::<f64>();
            if self.sliding.iter().any(|&switch| along(surfaces.parts[switch].clone()) < 0.0) {
                return false;
            }
        }
        true
    }

    /// The unit vectors that influence their own σ̇; the directions of the others follow σ at every stage.
    fn turning(&mut self, points: &[Vec<f64>]) -> Turning {
        let (mut turning, mut following, mut first) = (Vec::new(), Vec::new(), 0);
        for &switch in &self.sliding {
            let part = self.field.surfaces.parts[switch].clone();
            let rows = first..first + part.len();
            first = rows.end;
            if self.influence.rows_range(rows.clone()).amax() == 0.0 {
                following.push(switch);
            } else {
                turning.push((rows, part));
            }
        }
        for (i, point) in points.iter().enumerate().filter(|_| !following.is_empty()) {
            self.surfaces_at(i, point);
            let (s, surfaces) = (&mut self.step.signs[RADAU_STAGES[i + 1]], &self.field.surfaces);
            for &switch in &following {
                let length = surfaces.size(switch);
                for c in surfaces.parts[switch].clone().filter(|_| length > 0.0) {
                    s[c] = surfaces.sigma[c] / length;
                }
            }
        }
        turning
    }

    /// Newton's step for `Q_iᵀ σ(X_i) = 0` in the directions of all stages, where the columns of `Q_i` span what is normal to
    /// them; false if there is no such step.
    fn turn_directions(&mut self, points: &[Vec<f64>]) -> bool {
        let (size, h) = (self.influence.amax(), self.h);
        let turning = self.turning(points);
        let unknowns = turning.iter().map(|(_, part)| part.len() - 1).sum();
        if unknowns == 0 {
            return true;
        }
        let mut normals = DMatrix::zeros(self.influence.nrows(), 3 * unknowns);
        let mut right = DVector::zeros(3 * unknowns);
        let mut lengths = DVector::zeros(3 * unknowns);
        for (i, point) in points.iter().enumerate() {
            self.surfaces_at(i, point);
            let mut column = i * unknowns;
            for (rows, part) in &turning {
                let s = &self.step.signs[RADAU_STAGES[i + 1]][part.clone()];
                let sigma = &self.field.surfaces.sigma[part.clone()];
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
        let mut matrix = normals.tr_mul(&(&self.influence * &normals));
        for i in 0..3 {
            for j in 0..3 {
                let mut block = matrix.view_mut((i * unknowns, j * unknowns), (unknowns, unknowns));
                block *= h * A[i][j];
            }
        }
        for (a, length) in lengths.iter().enumerate() {
            matrix[(a, a)] -= length;
        }
        let Some(turn) = solve_vector(matrix, &right).filter(|turn| turn.iter().all(|v| v.is_finite())) else {
            return false;
        };
        let steps: [DVector<f64>; 3] =
            std::array::from_fn(|i| normals.columns(i * unknowns, unknowns) * turn.rows(i * unknowns, unknowns));
        self.turn_by(&steps, &turning);
        true
    }

    /// Turns the directions of the stages by steps that are shortened to stay on one side.
    fn turn_by(&mut self, steps: &[DVector<f64>; 3], turning: &Turning) {
        let shorten = (0.7 / steps.iter().fold(0.0f64, |largest, step| largest.max(step.amax()))).min(1.0);
        for (i, step) in steps.iter().enumerate() {
            for (rows, part) in turning {
                let s = &mut self.step.signs[RADAU_STAGES[i + 1]][part.clone()];
                for (s, row) in s.iter_mut().zip(rows.clone()) {
                    *s += shorten * step[row];
                }
                let length = norm(s);
                divide(s, length);
            }
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
