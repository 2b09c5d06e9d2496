//! The primal–dual interior-point method with Mehrotra's predictor and corrector (Mehrotra 1992; Nocedal and Wright 2006, section
//! 16.6).
//!
//! The states obey the dynamics from the start, so that what converges is the slope with respect to the inputs, the residuals
//! of the inequalities, and complementarity.

use super::super::program::StageProgram;
use super::super::recursion::Recursion;
use super::blocks::{Block, Blocks};
use super::constraints::{Constraints, Function};
use bracketry_numerics::rows::{add_multiple, add_symmetric_times};

/// First distance from a bound and first complementarity, in units of the sizes.
const FIRST_DISTANCE: f64 = 0.1;
const FIRST_GAP: f64 = 0.1;
/// Largest gap of a solution and the smallest that a step aims at, relative to the tolerance: what is that close to a bound that it
/// belongs there should have a multiplier, and what is not should have none.
const GAP: f64 = 1e-2;
const LEAST_GAP: f64 = 1e-3;
/// Share of the mean product that may be left after a step with terms of second order, and the share that one without them aims at.
const PROGRESS: f64 = 0.9;
const CENTERING: f64 = 0.3;
/// Share of the way to the boundary that a step goes at least.
const BOUNDARY: f64 = 0.995;
/// Shortest step; after as many of them in a row the method has failed.
const SHORTEST: f64 = 1e-3;
const PATIENCE: usize = 4;
/// What counts as coming closer to the solution; after as many steps that do not, the method has failed.
const FALL: f64 = 0.8;
const PERSISTENCE: usize = 15;

/// How the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    Solved,
    Limit,
    Failed,
}

/// A point, or a direction: variables of the blocks; slacks by function; distances and multipliers by row of the program.
#[derive(Clone, Default)]
pub(super) struct Point {
    pub(super) w: Vec<Vec<f64>>,
    pub(super) s: Vec<f64>,
    t: Vec<f64>,
    pub(super) v: Vec<f64>,
}

impl Point {
    fn zero(blocks: &Blocks, functions: usize, rows: usize) -> Self {
        let w = blocks.all.iter().map(|b| vec![0.0; b.size()]).collect();
        Self { w, s: vec![0.0; functions], t: vec![0.0; rows], v: vec![0.0; rows] }
    }
}

/// What of the elimination of the distances and of a slack is needed to find them again, by function.
#[derive(Clone, Copy, Default)]
struct Elimination {
    /// The slack moves by rest + share·aᵀdw.
    rest: f64,
    share: f64,
    /// Stiffness of the slack: its own curvature and that of its rows.
    stiffness: f64,
}

/// The method with its memory.
pub(super) struct InteriorPoint {
    recursion: Recursion,
    pub(super) at: Point,
    step: Point,
    /// aᵀw at the point, and along the direction.
    values: Vec<f64>,
    moved: Vec<f64>,
    /// Slope of the objective and the multipliers, by block; then with the forces of a direction.
    slope: Vec<Vec<f64>>,
    right: Vec<Vec<f64>>,
    /// Largest part of the slope, which says how much of it is rounding.
    terms: Vec<Vec<f64>>,
    /// Residual of every row, its elimination, and t v − what it shall be.
    residual: Vec<f64>,
    excess: Vec<f64>,
    eliminated: Vec<Elimination>,
    weights: Vec<f64>,
    forces: Vec<f64>,
    slack_slope: Vec<f64>,
    /// Multipliers of the dynamics between two blocks.
    multiplier: Vec<f64>,
}

/// Rows of a function with the coefficients of aᵀw and of the slack in them.
fn rows(f: &Function) -> impl Iterator<Item = (usize, f64, f64)> {
    let softened = if f.slack.is_some() { -1.0 } else { 0.0 };
    let bound = f.slack.and_then(|s| s.bound).map(|row| (row, 0.0, -1.0));
    f.sides().map(move |(row, sign)| (row, sign, softened)).chain(bound)
}

/// Right-hand side of a row: without what its function is where w = 0.
fn bound_of(program: &StageProgram, f: &Function, row: usize, sign: f64) -> f64 {
    program.right[row] - sign * f.constant
}

impl InteriorPoint {
    pub(super) fn new(blocks: &Blocks, constraints: &Constraints, rows: usize) -> Self {
        let functions = constraints.functions.len();
        let point = Point::zero(blocks, functions, rows);
        Self {
            recursion: Recursion::new(blocks.n, blocks.all.iter().map(|b| b.shape).collect()),
            slope: point.w.clone(),
            right: point.w.clone(),
            terms: point.w.clone(),
            at: point.clone(),
            step: point,
            values: vec![0.0; functions],
            moved: vec![0.0; functions],
            residual: vec![0.0; rows],
            excess: vec![0.0; rows],
            eliminated: vec![Elimination::default(); functions],
            weights: vec![0.0; functions],
            forces: vec![0.0; functions],
            slack_slope: vec![0.0; functions],
            multiplier: vec![0.0; blocks.n],
        }
    }

    /// Solves from scratch; `spent` says whether the time is over. The number of iterations comes with the outcome.
    pub(super) fn solve(
        &mut self,
        program: &StageProgram,
        blocks: &Blocks,
        constraints: &Constraints,
        (tolerance, most): (f64, u32),
        mut spent: impl FnMut() -> bool,
    ) -> (Outcome, u32) {
        let of = Problem { program, blocks, constraints };
        if !self.start(&of) {
            return (Outcome::Failed, 0);
        }
        let (mut short, mut lost) = (0, 0);
        // What is left of the residuals, which every step shortens by its length, and the gap: the least so far.
        let (mut left, mut least_left, mut least_gap) = (1.0_f64, 1.0, f64::INFINITY);
        for iteration in 0..=most {
            self.evaluate(&of);
            if self.is_solved(&of, tolerance, GAP) {
                return (Outcome::Solved, iteration);
            }
            if iteration == most || spent() {
                return (Outcome::Limit, iteration);
            }
            let Some(length) = self.iterate(&of, tolerance) else { return (self.given_up(&of, tolerance), iteration) };
            short = if length < SHORTEST { short + 1 } else { 0 };
            left = (left * (1.0 - length)).max(f64::EPSILON);
            let gap = self.mean_gap();
            lost += 1;
            if left < FALL * least_left || gap < FALL * least_gap {
                (least_left, least_gap, lost) = (left.min(least_left), gap.min(least_gap), 0);
            }
            if short == PATIENCE || lost == PERSISTENCE {
                self.evaluate(&of);
                return (self.given_up(&of, tolerance), iteration + 1);
            }
        }
        (Outcome::Limit, most)
    }

    /// The minimum of the objective with the functions held near zero, at distances from all bounds.
    fn start(&mut self, of: &Problem<'_>) -> bool {
        let unit = of.program.objective_scale;
        for (f, weight) in of.constraints.functions.iter().zip(&mut self.weights) {
            *weight = unit / of.program.row_scale[f.upper].powi(2);
        }
        for (block, slope) in of.blocks.all.iter().zip(&mut self.slope) {
            slope.iter_mut().zip(block.gradient()).for_each(|(g, of_block)| *g = of_block);
        }
        if !self.factorize(of) {
            return false;
        }
        self.recursion.solve(|j| of.flow(j), &self.slope, true, &mut self.at.w);
        of.constraints.values(&self.at.w, &mut self.values);
        for (i, f) in of.constraints.functions.iter().enumerate() {
            let scale = of.program.row_scale[f.upper];
            let (distance, force) = (FIRST_DISTANCE * scale, FIRST_GAP * unit / scale);
            let mut held = 0.0;
            self.at.s[i] = if f.slack.is_some() { distance } else { 0.0 };
            for (row, sign) in f.sides() {
                let t = bound_of(of.program, f, row, sign) - sign * self.values[i] + self.at.s[i];
                self.at.t[row] = t.abs().max(distance);
                self.at.v[row] = force * scale / self.at.t[row];
                held += self.at.v[row];
            }
            if let Some(slack) = f.slack {
                let (linear, curvature) = (of.program.gradient[slack.variable], of.program.hessian[slack.variable]);
                // A slack that costs much starts close to its bound.
                let s = (FIRST_GAP * unit / linear.max(unit / scale)).min(distance);
                if let Some(row) = slack.bound {
                    self.at.s[i] = s;
                    self.at.t[row] = s;
                    self.at.v[row] = (linear + curvature * s - held).max(FIRST_GAP * unit / s);
                }
            }
        }
        true
    }

    /// Values, residuals, and slopes at the point.
    fn evaluate(&mut self, of: &Problem<'_>) {
        of.constraints.values(&self.at.w, &mut self.values);
        for (i, f) in of.constraints.functions.iter().enumerate() {
            let mut held = 0.0;
            self.forces[i] = 0.0;
            for (row, sign, slack) in rows(f) {
                let known = bound_of(of.program, f, row, sign);
                self.residual[row] = sign * self.values[i] + slack * self.at.s[i] + self.at.t[row] - known;
                self.forces[i] += sign * self.at.v[row];
                held -= slack * self.at.v[row];
            }
            if let Some(slack) = f.slack {
                let (linear, curvature) = (of.program.gradient[slack.variable], of.program.hessian[slack.variable]);
                self.slack_slope[i] = linear + curvature * self.at.s[i] - held;
            }
        }
        for (j, (block, slope)) in of.blocks.all.iter().zip(&mut self.slope).enumerate() {
            self.terms[j].fill(0.0);
            slope.iter_mut().zip(block.gradient()).for_each(|(g, of_block)| *g = of_block);
            let terms = &mut self.terms[j];
            let mut note = |slope: &[f64]| terms.iter_mut().zip(slope).for_each(|(t, g)| *t = t.max(g.abs()));
            note(slope);
            add_symmetric_times(slope, &block.hessian, block.stride(), &self.at.w[j]);
            note(slope);
            of.constraints.add_forces(j, &self.forces, slope);
            note(slope);
        }
    }

    /// Mean product of distance and multiplier after a step of this length.
    fn gap_after(&self, of: &Problem<'_>, length: f64) -> f64 {
        let product =
            |row: usize| (self.at.t[row] + length * self.step.t[row]) * (self.at.v[row] + length * self.step.v[row]);
        of.rows().map(product).sum::<f64>() / self.at.t.len().max(1) as f64
    }

    /// Sum of the products of distances and multipliers.
    fn gap(&self) -> f64 {
        self.at.t.iter().zip(&self.at.v).map(|(t, v)| t * v).sum()
    }

    fn mean_gap(&self) -> f64 {
        self.gap() / self.at.t.len().max(1) as f64
    }

    /// The outcome where no step leads on: rounding may have ended what had reached the tolerance.
    fn given_up(&mut self, of: &Problem<'_>, tolerance: f64) -> Outcome {
        if self.is_solved(of, tolerance, 1.0) { Outcome::Solved } else { Outcome::Failed }
    }

    /// Whether the point is optimal to this accuracy, its gap to this share of it, relative to the sizes of the problem.
    fn is_solved(&mut self, of: &Problem<'_>, tolerance: f64, share: f64) -> bool {
        let (program, unit) = (of.program, of.program.objective_scale);
        let infeasible = of.rows().any(|row| {
            let size = program.row_scale[row].max(program.right[row].abs());
            self.residual[row].is_nan() || self.residual[row].abs() > tolerance * size
        });
        if infeasible {
            return false;
        }
        let gap = self.gap();
        let mut objective = 0.0;
        for (block, w) in of.blocks.all.iter().zip(&self.at.w) {
            objective += w.iter().zip(block.gradient()).map(|(w, g)| w * g).sum::<f64>();
        }
        if gap.is_nan() || gap > share * tolerance * unit.max(objective.abs()) {
            return false;
        }
        // The slope with respect to the inputs, the states following: multipliers of the dynamics come from the end.
        let n = of.blocks.n;
        self.multiplier.fill(0.0);
        for (j, block) in of.blocks.all.iter().enumerate().rev() {
            let right = &mut self.right[j];
            right.copy_from_slice(&self.slope[j]);
            let stride = block.stride();
            if j + 1 < of.blocks.all.len() {
                for (row, y) in block.flow(n).chunks_exact(stride).zip(&self.multiplier) {
                    add_multiple(right, *y, &row[..block.size()]);
                }
            }
            if block.shape.states > 0 {
                self.multiplier.copy_from_slice(&right[block.shape.inputs..]);
            }
            let small = |i: usize| {
                let size = program.scale[of.input(block, i)];
                right[i].abs() * size <= tolerance * unit.max(self.terms[j][i] * size)
            };
            if !(0..block.shape.inputs).all(small) {
                return false;
            }
        }
        of.constraints.functions.iter().zip(&self.slack_slope).all(|(f, slope)| {
            f.slack.is_none_or(|s| {
                let unit = unit.max(program.gradient[s.variable].abs() * program.scale[s.variable]);
                slope.abs() * program.scale[s.variable] <= tolerance * unit
            })
        })
    }

    fn factorize(&mut self, of: &Problem<'_>) -> bool {
        let weights = &self.weights;
        let fill = |j: usize, m: &mut [f64]| {
            let block = &of.blocks.all[j];
            m.copy_from_slice(&block.hessian);
            of.constraints.add_squares(j, block, weights, m);
        };
        self.recursion.factorize(|j| of.flow(j), fill)
    }

    /// One step; its length, `None` where the linear system has no solution.
    fn iterate(&mut self, of: &Problem<'_>, tolerance: f64) -> Option<f64> {
        for (i, f) in of.constraints.functions.iter().enumerate() {
            let stiffness = |row: usize| self.at.v[row] / self.at.t[row];
            let (upper, lower) = (stiffness(f.upper), f.lower.map_or(0.0, stiffness));
            self.eliminated[i] = Elimination::default();
            self.weights[i] = upper + lower;
            if let Some(slack) = f.slack {
                let own = of.program.hessian[slack.variable] + slack.bound.map_or(0.0, stiffness);
                let whole = own + upper + lower;
                self.weights[i] = ((upper + lower) * own + 4.0 * upper * lower) / whole;
                self.eliminated[i] = Elimination { rest: 0.0, share: (upper - lower) / whole, stiffness: whole };
            }
        }
        if !self.factorize(of) {
            return None;
        }
        let mean = self.mean_gap();
        for row in of.rows() {
            self.excess[row] = self.at.t[row] * self.at.v[row];
        }
        self.direction(of);
        let length = self.longest(of, 1.0);
        let centering = if mean > 0.0 { (self.gap_after(of, length) / mean).powi(3).clamp(0.0, 1.0) } else { 0.0 };
        // Products far below what is asked for would only spoil the linear system.
        let least = LEAST_GAP * tolerance * of.program.objective_scale / self.at.t.len().max(1) as f64;
        let aim = (centering * mean).max(least);
        // The terms of second order count as far as the step goes that they are taken from (Colombo and Gondzio 2008).
        let weight = length * length;
        for row in of.rows() {
            self.excess[row] = self.at.t[row] * self.at.v[row] + weight * self.step.t[row] * self.step.v[row] - aim;
        }
        self.direction(of);
        let mut length = self.longest(of, BOUNDARY);
        if self.gap_after(of, length) > PROGRESS * mean {
            // The terms of second order mislead where they are large: without them, toward the center.
            let aim = (CENTERING * mean).max(aim);
            for row in of.rows() {
                self.excess[row] = self.at.t[row] * self.at.v[row] - aim;
            }
            self.direction(of);
            length = self.longest(of, BOUNDARY);
        }
        if !length.is_finite() {
            return None;
        }
        self.advance(of, length);
        Some(length)
    }

    /// The direction whose products t v become what they shall be, to first order.
    fn direction(&mut self, of: &Problem<'_>) {
        for (i, f) in of.constraints.functions.iter().enumerate() {
            // What the multiplier of a row becomes without the variables moving.
            let change = |row: usize| (self.at.v[row] * self.residual[row] - self.excess[row]) / self.at.t[row];
            let (mut along, mut of_slack) = (0.0, -self.slack_slope[i]);
            for (row, sign, slack) in rows(f) {
                let c = change(row);
                along += sign * c;
                of_slack -= slack * c;
            }
            let e = &mut self.eliminated[i];
            if f.slack.is_some() {
                e.rest = of_slack / e.stiffness;
                along -= e.share * of_slack;
            }
            self.forces[i] = along;
        }
        for (j, right) in self.right.iter_mut().enumerate() {
            right.copy_from_slice(&self.slope[j]);
            of.constraints.add_forces(j, &self.forces, right);
        }
        self.recursion.solve(|j| of.flow(j), &self.right, false, &mut self.step.w);
        of.constraints.values(&self.step.w, &mut self.moved);
        for (i, f) in of.constraints.functions.iter().enumerate() {
            let e = self.eliminated[i];
            self.step.s[i] = e.rest + e.share * self.moved[i];
            for (row, sign, slack) in rows(f) {
                let change = sign * self.moved[i] + slack * self.step.s[i];
                self.step.t[row] = -self.residual[row] - change;
                self.step.v[row] = -(self.excess[row] + self.at.v[row] * self.step.t[row]) / self.at.t[row];
            }
        }
    }

    /// Longest step, at most 1, that goes at most this share of the way to zero of every distance and multiplier.
    fn longest(&self, of: &Problem<'_>, share: f64) -> f64 {
        let mut length = 1.0_f64;
        for row in of.rows() {
            for (at, step) in [(self.at.t[row], self.step.t[row]), (self.at.v[row], self.step.v[row])] {
                if step < 0.0 {
                    length = length.min(-share * at / step);
                } else if step.is_nan() {
                    return f64::NAN;
                }
            }
        }
        length
    }

    fn advance(&mut self, of: &Problem<'_>, length: f64) {
        for (w, d) in self.at.w.iter_mut().zip(&self.step.w) {
            add_multiple(w, length, d);
        }
        self.at.s.iter_mut().zip(&self.step.s).for_each(|(s, d)| *s += length * d);
        for row in of.rows() {
            self.at.t[row] += length * self.step.t[row];
            self.at.v[row] += length * self.step.v[row];
        }
    }
}

/// What is solved.
struct Problem<'a> {
    program: &'a StageProgram,
    blocks: &'a Blocks,
    constraints: &'a Constraints,
}

impl<'a> Problem<'a> {
    /// The state at the end of a block.
    fn flow(&self, j: usize) -> &'a [f64] {
        self.blocks.all[j].flow(self.blocks.n)
    }

    /// All rows of the program.
    fn rows(&self) -> std::ops::Range<usize> {
        0..self.program.right.len()
    }

    /// Number in the program of variable `i` of a block, an input.
    fn input(&self, block: &Block, i: usize) -> usize {
        let m = self.program.inputs;
        self.program.input(block.first + block.length - 1 - i / m, i % m)
    }
}
