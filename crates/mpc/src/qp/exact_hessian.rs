//! Exact Hessians of the stages' Lagrangians in convex programs.
//!
//! The exact block of grid point k is dt ∇²l + ∇²(λ_kᵀF), that of the Gauss–Newton program the convexified dt ∇²l. Where every
//! exact block is positive semidefinite, they are taken as they are. Else curvature is moved from grid point to grid point,
//! which changes no value of the program where the dynamics hold: going from the end to the start,
//!
//! ```text
//! ½ sᵀ P_{k+1} s − ½ dx_{k+1}ᵀ P_{k+1} dx_{k+1},    s = A_k dx_k + B_k du_k + c_k
//! ```
//!
//! is added, with P_k the Schur complement of the inputs' block less a small multiple of 1 (Verschueren, Zanon, Quirynen, and Diehl
//! 2017). A program whose Hessian is positive definite in the directions that obey the dynamics becomes convex with the same
//! solution. Where it is not, as far from a solution, the exact blocks are moved toward those of the Gauss–Newton program until it
//! is, or, where that has no curvature to speak of, some is added to every variable.
//!
//! Directions in which active bounds hold the solution need no curvature of the Lagrangian: each adds its multiplier over its
//! distance, as the barrier of an interior-point method does. That changes nothing where the bound stays active, and only
//! shortens the step where it does not.
//!
//! The exact block also has the curvature of the path constraints, for the multipliers of their rows.

use super::program::{NOWHERE, StageProgram};
use crate::ocp::{CostFunction, Moves, Ocp};
use crate::transcription::{ShootingLinearization, carry_block};
use bracketry_numerics::dense::is_positive_definite;
use std::ops::Range;

/// Curvature that is left at the states, relative to the largest of all.
const LEFT: f64 = 1e-8;
/// Curvature, relative to the largest of a block, below which it does not count as positive.
const ROUNDING: f64 = 1e-10;

/// Smallest curvature of the inputs relative to that of the Gauss–Newton program: keeps steps from becoming huge.
const SHARE: f64 = 0.1;

/// Shares of the exact Hessian that are tried, the rest being that of the Gauss–Newton program.
const BLENDS: [f64; 4] = [1.0, 0.5, 0.25, 0.1];
/// Curvature of the Gauss–Newton program, relative to that of the exact one, below which it offers none.
const FLAT: f64 = 1e-6;
/// Curvature that is added to every variable then, relative to the largest of all: the first that is tried, the largest, and the
/// factors from try to try and from program to program (inertia correction of Wächter and Biegler 2006).
const FIRST_SHIFT: f64 = 1e-6;
const LARGEST_SHIFT: f64 = 1e2;
const GROWTH: f64 = 8.0;
const SHRINKAGE: f64 = 3.0;
/// Largest curvature of an active bound, relative to the largest of all.
const HELD: f64 = 10.0;

/// An active bound with multiplier z at the distance s.
struct Held {
    /// Grid point.
    k: usize,
    /// Where the entries of its gradient stand.
    gradient: Range<usize>,
    /// z/s.
    curvature: f64,
}

/// What active bounds hold.
#[derive(Default)]
pub(super) struct HeldBounds {
    bounds: Vec<Held>,
    /// Entries of the gradients with respect to (x, u), one bound after the other.
    gradients: Vec<(usize, f64)>,
}

impl HeldBounds {
    pub(super) fn clear(&mut self) {
        self.bounds.clear();
        self.gradients.clear();
    }

    /// Adds a bound at grid point `k` by the entries of its gradient and its curvature z/s.
    pub(super) fn add(&mut self, k: usize, gradient: impl Iterator<Item = (usize, f64)>, curvature: f64) {
        let first = self.gradients.len();
        self.gradients.extend(gradient);
        self.bounds.push(Held { k, gradient: first..self.gradients.len(), curvature });
    }
}

/// The blocks, in memory that is kept.
#[derive(Default)]
pub(super) struct StageBlocks {
    /// Slots of all places (i ≤ j) of the blocks, stage by stage.
    pub(super) slots: Vec<Vec<usize>>,
    /// Exact blocks less those of the Gauss–Newton program.
    extra: Vec<f64>,
    /// Blocks of the Gauss–Newton program, states and inputs in units of their sizes.
    base: Vec<f64>,
    /// Blocks of the convex program, likewise.
    stages: Vec<f64>,
    /// P_{k+1} of every interval, N blocks of n rows of n; empty where no curvature was moved.
    moved: Vec<f64>,
    /// What active bounds hold.
    pub(super) held: HeldBounds,
    /// What stands at the place of another variable has no effect of its own.
    moves: Moves,
    /// Curvature that was added in the last program, relative to the largest of all; 0 if there was none.
    shift: f64,
    size: Vec<f64>,
    /// P_N, P_k.
    terminal: Vec<f64>,
    p: Vec<f64>,
    product: Vec<f64>,
    factor: Vec<f64>,
}

/// Places (i ≤ j) of a symmetric block, row by row.
pub(super) fn block_places(w: usize) -> impl Iterator<Item = (usize, usize)> + Clone {
    (0..w).flat_map(move |i| (i..w).map(move |j| (i, j)))
}

impl StageBlocks {
    /// Without blocks.
    pub(super) fn new(moves: Moves) -> Self {
        Self { moves, ..Self::default() }
    }

    /// Notes what the exact block of stage k has beyond the convexified one of the cost, weight and entries of which are given.
    pub(super) fn note(
        &mut self,
        k: usize,
        w: usize,
        lin: &ShootingLinearization,
        cost: Option<(&CostFunction, f64, &[f64])>,
    ) {
        let range = k * w * w..(k + 1) * w * w;
        self.extra.resize(self.slots.len() * w * w, 0.0);
        let extra = &mut self.extra[range.clone()];
        match lin.curvature.get(range) {
            Some(curvature) => extra.copy_from_slice(curvature),
            None => extra.fill(0.0),
        }
        if let Some((cost, weight, convexified)) = cost {
            extra.iter_mut().zip(cost.last_hessian()).for_each(|(e, h)| *e += weight * h);
            for (&(i, j), h) in cost.hessian_pattern().iter().zip(convexified) {
                extra[i * w + j] -= h;
                if i != j {
                    extra[j * w + i] -= h;
                }
            }
            carry_block(self.moves.at(k), w, extra);
        }
    }

    /// What the exact block of stage k has beyond the convexified one, to be added to; w rows of w.
    pub(super) fn exact_block(&mut self, k: usize, w: usize) -> &mut [f64] {
        &mut self.extra[k * w * w..(k + 1) * w * w]
    }

    /// The same, to be read.
    pub(super) fn beyond_gauss_newton(&self, k: usize, w: usize) -> &[f64] {
        &self.extra[k * w * w..(k + 1) * w * w]
    }

    /// Multipliers of the program as it was before curvature was moved: y_k − P_{k+1} dx_{k+1}.
    pub(super) fn correct_multipliers(&self, dx: &[f64], multipliers: &mut [f64], n: usize) {
        for (k, p) in self.moved.chunks_exact(n * n).enumerate() {
            let dx = &dx[(k + 1) * n..(k + 2) * n];
            for (y, row) in multipliers[k * n..(k + 1) * n].iter_mut().zip(p.chunks_exact(n)) {
                *y -= row.iter().zip(dx).map(|(p, d)| p * d).sum::<f64>();
            }
        }
    }
}

impl StageBlocks {
    /// Puts as much of the exact Hessian as gives a convex program in the place of the Gauss–Newton one, once flow and costs have
    /// been filled in.
    pub(super) fn use_exact_hessian(
        &mut self,
        p: &mut StageProgram,
        terminal_slots: &[usize],
        ocp: &Ocp,
        lin: &ShootingLinearization,
    ) {
        self.moved.clear();
        let (n, m, steps) = (p.states, p.inputs, p.steps);
        let w = n + m;
        let finite = self.extra.iter().chain(&lin.jacobian).chain(&p.defect).chain(&p.hessian).all(|h| h.is_finite());
        if steps == 0 || !finite || self.extra.iter().all(|h| *h == 0.0) {
            return;
        }
        self.size.clear();
        self.size.extend((0..n).map(|i| p.scale[p.state(1, i)]).chain((0..m).map(|j| p.scale[p.input(0, j)])));
        let size = &self.size;
        self.base.clear();
        self.base.resize(steps * w * w, 0.0);
        for (slots, block) in self.slots.iter().zip(self.base.chunks_exact_mut(w * w)) {
            for (&slot, (i, j)) in slots.iter().zip(block_places(w)).filter(|(s, _)| **s != NOWHERE) {
                let h = p.hessian[slot] * size[i] * size[j];
                block[i * w + j] = h;
                block[j * w + i] = h;
            }
        }
        let terminal_places = ocp.terminal.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        let off_diagonal = || terminal_slots.iter().zip(terminal_places).filter(|(_, (i, j))| i != j);
        self.terminal.clear();
        self.terminal.resize(n * n, 0.0);
        for (&slot, &(i, j)) in off_diagonal() {
            let h = p.hessian[slot] * size[i] * size[j];
            self.terminal[i * n + j] = h;
            self.terminal[j * n + i] = h;
        }
        for i in 0..n {
            self.terminal[i * n + i] = p.hessian[p.state(steps, i)] * size[i] * size[i];
        }
        if !BLENDS.iter().any(|&share| self.blend(p, lin, share, 0.0)) && !self.shift_until_convex(p, lin) {
            self.moved.clear();
            return;
        }
        let size = &self.size;
        for (slots, block) in self.slots.iter().zip(self.stages.chunks_exact(w * w)) {
            for (&slot, (i, j)) in slots.iter().zip(block_places(w)).filter(|(s, _)| **s != NOWHERE) {
                p.hessian[slot] = block[i * w + j] / (size[i] * size[j]);
            }
        }
        if self.moved.is_empty() {
            return;
        }
        let left = LEFT * largest_of(&self.base);
        for (&slot, _) in off_diagonal() {
            p.hessian[slot] = 0.0;
        }
        for i in 0..n {
            let v = p.state(steps, i);
            p.hessian[v] = left / (size[i] * size[i]);
        }
        let defect = std::mem::take(&mut p.defect);
        self.add_slope(p, &lin.jacobian, &defect);
        p.defect = defect;
    }
}

impl StageBlocks {
    /// Adds what moved curvature adds to the gradient for these defects c_k: [A_k B_k]ᵀ P_{k+1} c_k.
    pub(super) fn add_slope(&self, program: &mut StageProgram, flow: &[f64], defects: &[f64]) {
        let n = program.states;
        let w = n + program.inputs;
        for (k, p) in self.moved.chunks_exact(n * n).enumerate() {
            let c = &defects[k * n..(k + 1) * n];
            for (i, row) in p.chunks_exact(n).enumerate() {
                let force: f64 = row.iter().zip(c).map(|(p, c)| p * c).sum();
                for j in 0..w {
                    if let Some(v) = program.variable(k, j) {
                        program.gradient[v] += flow[(k * n + i) * w + j] * force;
                    }
                }
            }
        }
    }

    /// Where the program of Gauss and Newton has hardly any curvature to move toward, as with an economic cost: adds as little as
    /// makes that of the exact Hessian convex. False where there is enough, or even the largest shift is too small.
    fn shift_until_convex(&mut self, program: &StageProgram, lin: &ShootingLinearization) -> bool {
        let last = std::mem::take(&mut self.shift);
        let size = &self.size;
        let w = size.len();
        let exact = self.extra.iter().enumerate().map(|(e, h)| (h * size[e % (w * w) / w] * size[e % w]).abs());
        if largest_of(&self.base) > FLAT * exact.fold(0.0, f64::max) {
            return false;
        }
        let mut shift = (last / SHRINKAGE).max(FIRST_SHIFT);
        while shift <= LARGEST_SHIFT {
            if self.blend(program, lin, 1.0, shift) {
                self.shift = shift;
                return true;
            }
            shift *= GROWTH;
        }
        false
    }

    /// Whether the program with this share of the exact Hessian, and this relative curvature added, is convex, with curvature moved
    /// if need be.
    fn blend(&mut self, program: &StageProgram, lin: &ShootingLinearization, share: f64, shift: f64) -> bool {
        let (n, m, steps) = (program.states, program.inputs, program.steps);
        let w = n + m;
        let Self { extra, base, stages, moved, size, terminal, p, product, factor, held, moves, .. } = self;
        stages.clear();
        stages.extend(base.iter().zip(&*extra).enumerate().map(|(e, (b, x))| {
            let (i, j) = (e % (w * w) / w, e % w);
            b + share * x * size[i] * size[j]
        }));
        let cap = HELD * largest_of(stages);
        for Held { k, gradient, curvature } in &held.bounds {
            let gradient = &held.gradients[gradient.clone()];
            let square: f64 = gradient.iter().map(|(i, a)| (a * size[*i]).powi(2)).sum();
            let h = curvature.min(cap / square);
            for &(i, a) in gradient {
                for &(j, b) in gradient {
                    stages[(k * w + i) * w + j] += h * a * size[i] * b * size[j];
                }
            }
        }
        if shift > 0.0 {
            let added = shift * largest_of(stages);
            stages.iter_mut().enumerate().filter(|(e, _)| e % (w * w) % (w + 1) == 0).for_each(|(_, h)| *h += added);
        }
        // The state of grid point 0 is fixed.
        stages[..n * w].fill(0.0);
        (n..w).for_each(|j| stages[j * w..j * w + n].fill(0.0));
        moved.clear();
        if stages.chunks_exact(w * w).all(|b| is_convex(b, w, factor)) {
            return true;
        }
        let left = LEFT * largest_of(base);
        p.clear();
        p.extend_from_slice(terminal);
        (0..n).for_each(|i| p[i * n + i] -= left);
        moved.resize(steps * n * n, 0.0);
        product.resize(n.max(m) * w, 0.0);
        for k in (0..steps).rev() {
            for (e, v) in moved[k * n * n..(k + 1) * n * n].iter_mut().enumerate() {
                *v = p[e] / (size[e / n] * size[e % n]);
            }
            // [A B] in units of the sizes.
            let flow = &lin.jacobian[k * n * w..(k + 1) * n * w];
            let entry = |i: usize, j: usize| flow[i * w + j] * size[j] / size[i];
            for i in 0..n {
                for j in 0..w {
                    product[i * w + j] = (0..n).map(|l| p[i * n + l] * entry(l, j)).sum();
                }
            }
            let block = &mut stages[k * w * w..(k + 1) * w * w];
            for j in 0..w {
                for l in 0..w {
                    block[j * w + l] += (0..n).map(|i| entry(i, j) * product[i * w + l]).sum::<f64>();
                }
            }
            // The inputs' block, less what it has to keep.
            let floor = ROUNDING * largest_of(block);
            let without_effect = |i: usize| moves.at(k).iter().any(|(from, _)| *from == i);
            let inputs = |share: f64, to: &mut Vec<f64>| {
                to.clear();
                to.extend((n..w).flat_map(|i| (n..w).map(move |j| (i, j))).map(|(i, j)| {
                    if without_effect(i) || without_effect(j) {
                        return f64::from(u8::from(i == j));
                    }
                    let keep = if i == j { floor } else { 0.0 };
                    block[i * w + j] - share * base[(k * w + i) * w + j] - keep
                }));
            };
            inputs(SHARE, factor);
            if !is_positive_definite(factor, m) {
                return false;
            }
            if k == 0 {
                break;
            }
            inputs(0.0, factor);
            if !is_positive_definite(factor, m) {
                return false;
            }
            // W with R = LLᵀ, LW = S: what stays at the states is WᵀW.
            for i in 0..m {
                for c in 0..n {
                    let known: f64 = (0..i).map(|l| factor[i * m + l] * product[l * n + c]).sum();
                    product[i * n + c] = (block[(n + i) * w + c] - known) / factor[i * m + i];
                }
            }
            for i in 0..n {
                for j in 0..n {
                    let stays: f64 = (0..m).map(|l| product[l * n + i] * product[l * n + j]).sum();
                    let stays = stays + if i == j { left } else { 0.0 };
                    p[i * n + j] = block[i * w + j] - stays;
                    block[i * w + j] = stays;
                }
            }
        }
        true
    }
}

fn largest_of(block: &[f64]) -> f64 {
    block.iter().fold(0.0, |l: f64, h| l.max(h.abs()))
}

/// Whether a symmetric matrix is positive semidefinite up to rounding.
fn is_convex(block: &[f64], w: usize, factor: &mut Vec<f64>) -> bool {
    let largest = largest_of(block);
    factor.clear();
    factor.extend_from_slice(block);
    (0..w).for_each(|i| factor[i * w + i] += ROUNDING * largest);
    largest == 0.0 || is_positive_definite(factor, w)
}
