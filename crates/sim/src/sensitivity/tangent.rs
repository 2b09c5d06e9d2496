//! The path of a simulation as a chain of linear maps: what small changes of the state and of the field lead to.
//!
//! Along a step the change `X` of the state obeys `X' = A X + b` with `A = ∂f/∂x` for the modes of the step, unit vectors that slide
//! turning with σ, and sticking signs answering so that `σ̇_K` stays zero. At an event `X` jumps by the [`Saltation`] matrix. The steps are the integrator's own, taken by the implicit midpoint rule.

use super::path::{Path, Piece};
use super::saltation::Saltation;
use crate::Switched;
use crate::friction::{FrictionMode, Surfaces, eliminate, norm};
use crate::model::Model;
use bracketry_numerics::eigen::pseudo_inverse;
use nalgebra::DMatrix;
use std::ops::Range;

/// Pivots below this part of the largest entry are none.
const SINGULAR: f64 = 1e-12;
/// Components that depend on each other may contradict each other by this part of their gradients: rounding.
const CONTRADICTION: f64 = 1e-9;

/// The linear maps along a [`Path`], with `n` states: `X ← T X + R b` by piece, where `b` is a change of the field.
#[derive(Debug, Clone, Default)]
pub struct Tangent {
    n: usize,
    /// By piece `n × n` by columns.
    transition: Vec<f64>,
    response: Vec<f64>,
    /// By piece, the field's derivatives by live numbers, `n` each.
    by_number: Vec<f64>,
    numbers: usize,
}

impl Tangent {
    /// Number of pieces.
    pub fn len(&self) -> usize {
        self.transition.len() / (self.n * self.n).max(1)
    }

    /// Whether there are no pieces.
    pub fn is_empty(&self) -> bool {
        self.transition.is_empty()
    }

    /// The field's derivatives by the live numbers of the model along a piece: `n` numbers for each.
    pub fn by_number(&self, piece: usize) -> &[f64] {
        let size = self.n * self.numbers;
        &self.by_number[piece * size..(piece + 1) * size]
    }

    /// Propagates changes of the state, `x` of `n` numbers each, over a piece along which the field changes by `b`; changes beyond
    /// those of `b` find the field as it is.
    pub fn propagate(&self, piece: usize, x: &mut [f64], b: &[f64], scratch: &mut Vec<f64>) {
        let n = self.n;
        let t = &self.transition[piece * n * n..(piece + 1) * n * n];
        let r = &self.response[piece * n * n..(piece + 1) * n * n];
        scratch.resize(n, 0.0);
        for (i, column) in x.chunks_exact_mut(n).enumerate() {
            scratch.fill(0.0);
            accumulate(t, column, scratch);
            if let Some(field) = b.get(i * n..(i + 1) * n) {
                accumulate(r, field, scratch);
            }
            column.copy_from_slice(scratch);
        }
    }
}

/// `y += M v`, by columns of `M`.
fn accumulate(matrix: &[f64], v: &[f64], y: &mut [f64]) {
    for (column, &factor) in matrix.chunks_exact(y.len()).zip(v) {
        if factor != 0.0 {
            for (y, m) in y.iter_mut().zip(column) {
                *y += m * factor;
            }
        }
    }
}

impl Model {
    /// The linear maps along a path of this model; false if the model was not made by [`Model::differentiable`], or where they
    /// are not finite.
    pub fn tangent(&mut self, path: &Path, tangent: &mut Tangent) -> bool {
        let (n, k) = (self.dim(), self.arguments());
        let Some((numbers, true)) = self.differentiated() else { return false };
        // A static level makes the field jump where what sticks breaks loose.
        if n == 0 || (0..self.switches()).any(|i| self.static_ratio(i) > 1.0) {
            return false;
        }
        tangent.n = n;
        tangent.numbers = numbers;
        tangent.transition.clear();
        tangent.response.clear();
        tangent.by_number.clear();
        let mut derivatives = vec![0.0; n * (n + k + numbers) + k * numbers];
        let moving = self.surfaces_move();
        let mut maps = Maps::new(self);
        for piece in &path.pieces {
            match *piece {
                Piece::Jump { first, rate } => {
                    let (jump, gradient) = path.numbers[first..first + 2 * n].split_at(n);
                    tangent.transition.extend(Saltation { jump, gradient, rate }.matrix());
                    tangent.response.resize(tangent.response.len() + n * n, 0.0);
                    tangent.by_number.resize(tangent.by_number.len() + n * numbers, 0.0);
                }
                Piece::Step { t, h, first, modes } => {
                    let (x, s) = path.numbers[first..first + n + k].split_at(n);
                    self.enter_segment(t);
                    self.derivatives(t, x, s, &mut derivatives);
                    let (field, rest) = derivatives.split_at(n * (n + k));
                    let (by_number, moved) = rest.split_at(n * numbers);
                    let modes = &path.modes[modes..modes + self.switches()];
                    if !maps.of_step(self, (t, h), (x, s), modes, field) {
                        return false;
                    }
                    tangent.transition.extend_from_slice(&maps.transition);
                    tangent.response.extend_from_slice(&maps.response);
                    let from = tangent.by_number.len();
                    tangent.by_number.extend_from_slice(by_number);
                    if moving {
                        let surfaces = &maps.surfaces;
                        for (part, _) in surfaces.parts.iter().zip(modes).filter(|(_, m)| **m == FrictionMode::Sliding)
                        {
                            let by_number = tangent.by_number[from..].chunks_exact_mut(n);
                            for (moved, out) in moved.chunks_exact(k).zip(by_number) {
                                turn(part, (s, &surfaces.sigma), |c| moved[c], &field[n * n..], out);
                            }
                        }
                    }
                }
            }
        }
        tangent.transition.iter().all(|v| v.is_finite()) && tangent.by_number.iter().all(|v| v.is_finite())
    }

    /// The derivatives of this model's field by its live numbers along a path of another model with the same states: by piece and
    /// number, `n` each. Signs of the other model that this one has too, by name, keep their values; others follow their
    /// switching functions. False where they are not finite, or the model was not made by [`Model::with_influences`].
    pub fn along(&mut self, other: &Model, path: &Path, by_number: &mut Vec<f64>) -> bool {
        let (n, k) = (self.dim(), self.arguments());
        let Some((numbers, false)) = self.differentiated() else { return false };
        if other.dim() != n {
            return false;
        }
        let (mut own, others) = (Surfaces::new(self), Surfaces::new(other).parts);
        let place = |name: &str| other.switch_names().position(|theirs| theirs == name);
        let known: Vec<Option<usize>> = self.switch_names().map(place).collect();
        let mut signs = vec![0.0; k];
        let mut derivatives = vec![0.0; n * (k + numbers) + k * numbers];
        let moving = self.surfaces_move();
        let size = n * numbers;
        by_number.clear();
        by_number.resize(path.len() * size, 0.0);
        for (piece, out) in path.pieces.iter().zip(by_number.chunks_exact_mut(size.max(1))) {
            let Piece::Step { t, first, .. } = *piece else { continue };
            let (x, rest) = path.numbers[first..].split_at(n);
            self.enter_segment(t);
            if moving || known.contains(&None) {
                own.evaluate(self, t, x);
            }
            let sigma = &own.sigma;
            for (part, known) in own.parts.iter().zip(&known) {
                match known.map(|i| others[i].clone()) {
                    Some(theirs) if theirs.len() == part.len() => {
                        signs[part.clone()].copy_from_slice(&rest[theirs]);
                    }
                    _ => {
                        let length = norm(&sigma[part.clone()]);
                        for c in part.clone() {
                            signs[c] = if length > 0.0 { sigma[c] / length } else { 0.0 };
                        }
                    }
                }
            }
            self.derivatives(t, x, &signs, &mut derivatives);
            let (by_sign, rest) = derivatives.split_at(n * k);
            let (field, moved) = rest.split_at(size);
            out.copy_from_slice(field);
            if moving {
                for part in own.parts.iter().filter(|part| part.len() > 1) {
                    for (moved, out) in moved.chunks_exact(k).zip(out.chunks_exact_mut(n)) {
                        turn(part, (&signs, sigma), |c| moved[c], by_sign, out);
                    }
                }
            }
        }
        by_number.iter().all(|v| v.is_finite())
    }

    /// By how much this model's field differs, along a path of another one with the same equations, because of its own samples: by piece
    /// `n` numbers. Samples count with their means over each step, so that delays far below a step keep their impulse. False
    /// where the models differ otherwise, or the field is not finite.
    pub fn by_samples(&mut self, other: &Model, path: &Path, changes: &mut Vec<f64>) -> bool {
        let (n, k) = (self.dim(), self.arguments());
        if n == 0 || !self.driven_like(other) {
            return false;
        }
        changes.clear();
        changes.resize(path.len() * n, 0.0);
        let mut without = vec![0.0; n];
        for (piece, out) in path.pieces.iter().zip(changes.chunks_exact_mut(n)) {
            let Piece::Step { t, h, first, .. } = *piece else { continue };
            let (x, s) = path.numbers[first..first + n + k].split_at(n);
            let span = (t - 0.5 * h, t + 0.5 * h);
            self.mean_field(span, (x, s), None, out);
            self.mean_field(span, (x, s), Some(other), &mut without);
            out.iter_mut().zip(&without).for_each(|(out, without)| *out -= without);
        }
        changes.iter().all(|v| v.is_finite())
    }
}

/// The maps of one step, `n × n` by columns.
struct Maps {
    n: usize,
    surfaces: Surfaces,
    /// `∂f/∂x`.
    a: Vec<f64>,
    /// Keeps `σ̇_K`: `I − F (G F)⁻¹ G`.
    projection: Vec<f64>,
    transition: Vec<f64>,
    response: Vec<f64>,
}

impl Maps {
    fn new(model: &Model) -> Self {
        let n = model.dim();
        let square = || vec![0.0; n * n];
        Self {
            n,
            surfaces: Surfaces::new(model),
            a: square(),
            projection: square(),
            transition: square(),
            response: square(),
        }
    }

    fn of_step(
        &mut self,
        model: &mut Model,
        (t, h): (f64, f64),
        (x, s): (&[f64], &[f64]),
        modes: &[FrictionMode],
        field: &[f64],
    ) -> bool {
        let n = self.n;
        let (by_state, by_sign) = field.split_at(n * n);
        self.a.copy_from_slice(by_state);
        let vectors = modes.contains(&FrictionMode::Sliding);
        let sticks = modes.contains(&FrictionMode::Sticking);
        if vectors || sticks {
            self.surfaces.differentiate(model, t, x);
        }
        if vectors {
            self.surfaces.evaluate(model, t, x);
            for (part, _) in self.surfaces.parts.iter().zip(modes).filter(|(_, m)| **m == FrictionMode::Sliding) {
                for (j, a) in self.a.chunks_exact_mut(n).enumerate() {
                    turn(part, (s, &self.surfaces.sigma), |c| self.surfaces.gradient(c)[j], by_sign, a);
                }
            }
        }
        if sticks {
            if !self.stick(modes, by_sign) {
                return false;
            }
            self.a = product(&self.projection, &self.a, n);
        }
        // (I − h/2 A) X⁺ = (I + h/2 A) X + h b, with what sticks taken off X and b; by rows.
        let mut matrix = vec![0.0; n * n];
        let mut right = vec![0.0; 2 * n * n];
        for i in 0..n {
            for j in 0..n {
                let (identity, a) = (f64::from(u8::from(i == j)), 0.5 * h * self.a[j * n + i]);
                matrix[i * n + j] = identity - a;
                right[2 * n * i + j] = identity + a;
                right[2 * n * i + n + j] = h * identity;
            }
        }
        let size = matrix.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        if !eliminate(&mut matrix, &mut right, n, SINGULAR * size) {
            return false;
        }
        let columns = |first: usize| (0..n * n).map(|at| right[2 * n * (at % n) + first + at / n]).collect();
        (self.transition, self.response) = (columns(0), columns(n));
        if sticks {
            self.transition = product(&self.transition, &self.projection, n);
            self.response = product(&self.response, &self.projection, n);
        }
        true
    }

    /// The projection for the components that stick; false where they do not determine each other.
    fn stick(&mut self, modes: &[FrictionMode], by_sign: &[f64]) -> bool {
        let n = self.n;
        let parts = self.surfaces.parts.iter().zip(modes);
        let sticking: Vec<usize> =
            parts.filter(|(_, m)| **m == FrictionMode::Sticking).flat_map(|(part, _)| part.clone()).collect();
        let m = sticking.len();
        let column = |c: usize| &by_sign[c * n..(c + 1) * n];
        let mut matrix = vec![0.0; m * m];
        let mut right = vec![0.0; m * n];
        for (a, &c) in sticking.iter().enumerate() {
            let row = self.surfaces.gradient(c);
            for (b, &d) in sticking.iter().enumerate() {
                matrix[a * m + b] = row.iter().zip(column(d)).map(|(g, f)| g * f).sum();
            }
            right[a * n..(a + 1) * n].copy_from_slice(row);
        }
        let size = matrix.iter().fold(0.0f64, |size, v| size.max(v.abs()));
        let all = DMatrix::from_row_slice(m, m, &matrix);
        if !eliminate(&mut matrix, &mut right, m, SINGULAR * size) {
            // Where the components depend on each other, so do their rows, and every solution has the same forces.
            let rows = DMatrix::from_fn(m, n, |a, j| self.surfaces.gradient(sticking[a])[j]);
            let Some(inverse) = pseudo_inverse(&all, SINGULAR * size) else {
                return false;
            };
            let shared = inverse * &rows;
            if (all * &shared - &rows).amax() > CONTRADICTION * rows.amax() {
                return false;
            }
            right.copy_from_slice(shared.transpose().as_slice());
        }
        for j in 0..n {
            for i in 0..n {
                let taken: f64 = sticking.iter().enumerate().map(|(a, &c)| column(c)[i] * right[a * n + j]).sum();
                self.projection[j * n + i] = f64::from(u8::from(i == j)) - taken;
            }
        }
        true
    }
}

/// Adds to a derivative `out` of the field what comes from a unit vector that turns with its σ, which has the derivative `moved`:
/// `∂f/∂s (I − s sᵀ)/|σ| ∂σ`.
fn turn(
    part: &Range<usize>,
    (s, sigma): (&[f64], &[f64]),
    moved: impl Fn(usize) -> f64,
    by_sign: &[f64],
    out: &mut [f64],
) {
    let (n, size) = (out.len(), norm(&sigma[part.clone()]));
    if size == 0.0 {
        return;
    }
    let along: f64 = part.clone().map(|c| s[c] * moved(c)).sum();
    for c in part.clone() {
        let change = (moved(c) - s[c] * along) / size;
        for (out, f) in out.iter_mut().zip(&by_sign[c * n..(c + 1) * n]) {
            *out += f * change;
        }
    }
}

/// `A B` of `n × n` matrices by columns.
fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n * n];
    for (column, out) in b.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
        accumulate(a, column, out);
    }
    out
}
