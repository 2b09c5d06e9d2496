//! Filling the stage program from the problem.

use super::assembly::Assembly;
use super::program::NOWHERE;
use crate::ocp::{CostPoint, Ocp};
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{ShootingLinearization, carry_block};
use std::ops::Range;

/// Smallest curvature of any variable, in units of its size and of the objective: keeps the program strictly convex.
const REGULARIZATION: f64 = 1e-9;

/// Distance from a bound, relative to the size of what it bounds, below which it counts as active, and the smallest that counts.
const ACTIVE: f64 = 1e-3;
const NEAR: f64 = 1e-8;

/// Smallest unit of the objective.
const SMALLEST_OBJECTIVE: f64 = 1e-12;

/// Where a problem is linearized.
#[derive(Clone, Copy)]
pub(super) struct LinearizationPoint<'a> {
    /// Grid point of the run at which the horizon starts.
    pub(super) k0: usize,
    pub(super) trajectory: &'a PlannedTrajectory,
    pub(super) lin: &'a ShootingLinearization,
}

impl Assembly {
    /// The unit of the objective: the most that moving a state or an input by its size changes, but no more than 1, so that
    /// tolerances mean something for costs in small units too.
    fn choose_objective_scale(&mut self) {
        let p = &mut self.program;
        let (mut curvature, mut slope) = (0.0_f64, 0.0_f64);
        for k in 0..=p.steps {
            let inputs = if k < p.steps { p.inputs } else { 0 };
            for v in (0..p.states + inputs).filter_map(|v| p.variable(k, v)) {
                curvature = curvature.max(p.hessian[v] * p.scale[v].powi(2));
                slope = slope.max((p.gradient[v] * p.scale[v]).abs());
            }
        }
        let size = if curvature > 0.0 { curvature } else { slope };
        p.objective_scale = if size > 0.0 { size.clamp(SMALLEST_OBJECTIVE, 1.0) } else { 1.0 };
    }

    fn regularize(&mut self, v: usize) {
        let p = &mut self.program;
        p.hessian[v] += REGULARIZATION * p.objective_scale / p.scale[v].powi(2);
    }

    /// Fills in every number; see [`Qp::assemble`](super::Qp::assemble).
    pub(super) fn fill(
        &mut self,
        ocp: &mut Ocp,
        at: LinearizationPoint<'_>,
        proximal: f64,
        hard: f64,
        row_multipliers: &[f64],
    ) {
        let (steps, trajectory) = (self.program.steps, at.trajectory);
        self.fill_curvature(ocp, proximal);
        self.program.gradient.fill(0.0);
        for s in &self.slacks {
            let (linear, quadratic) = s.softness.weights(s.factor, hard / s.scale);
            self.program.gradient[s.variable] = linear;
            self.program.hessian[s.variable] += 2.0 * quadratic;
        }
        for k in 0..steps {
            self.add_stage_cost(ocp, at, k);
        }
        self.add_end_cost(ocp, at);
        self.fill_flow(at, 0..steps);
        self.fill_bounds(ocp, trajectory);
        self.fill_constraints(ocp, at, 0..self.path.len(), 0..self.norm.len());
        self.add_row_curvature(ocp, at, row_multipliers);
        self.note_active_bounds(row_multipliers);
        if let Some(blocks) = &mut self.blocks {
            blocks.use_exact_hessian(&mut self.program, &self.terminal_slots, ocp, at.lin);
        }
        self.choose_objective_scale();
        for v in 0..self.program.variables() {
            self.regularize(v);
        }
        if let (Some(rows), Some(set)) = (&self.set, &ocp.terminal_set) {
            self.program.right[rows.row] = set.level.sqrt();
            let x = trajectory.x(steps);
            for (i, w) in rows.root.iter().enumerate() {
                self.program.right[rows.row + 1 + i] =
                    w.iter().zip(x).zip(&set.center).map(|((w, x), c)| w * (x - c)).sum();
            }
        }
    }

    /// Replaces the numbers of the first interval alone, after its state has become known.
    pub(super) fn fill_first(&mut self, ocp: &mut Ocp, at: LinearizationPoint<'_>, proximal: f64) {
        let p = &mut self.program;
        for &slot in self.stage_slots[0].iter().filter(|s| **s != NOWHERE) {
            p.hessian[slot] = 0.0;
        }
        for j in 0..p.inputs {
            let variable = p.input(0, j);
            p.gradient[variable] = 0.0;
            p.hessian[variable] = proximal * ocp.dt / ocp.input_trust[j].powi(2);
        }
        self.add_stage_cost(ocp, at, 0);
        for j in 0..self.program.inputs {
            self.regularize(self.program.input(0, j));
        }
        self.fill_flow(at, 0..1);
        for i in 0..self.path.len() {
            if self.path[i].k == 0 {
                self.fill_constraints(ocp, at, i..i + 1, 0..0);
            }
        }
        for i in 0..self.norm.len() {
            if self.norm[i].k == 0 {
                self.fill_constraints(ocp, at, 0..0, i..i + 1);
            }
        }
    }

    /// Moves the right-hand sides by the curvature of dynamics and constraints along the step `z`; see
    /// [`Qp::correct`](super::Qp::correct).
    pub(super) fn correct(&mut self, ocp: &mut Ocp, trial: LinearizationPoint<'_>, ends: &[f64], z: &[f64]) {
        let n = self.program.states;
        let change: Vec<f64> =
            ends.iter().enumerate().map(|(i, end)| end - trial.trajectory.x(i / n + 1)[i % n]).collect();
        self.program.defect.iter_mut().zip(&change).for_each(|(c, d)| *c += d);
        if let Some(blocks) = &self.blocks {
            blocks.add_slope(&mut self.program, &trial.lin.jacobian, &change);
        }
        if self.path.is_empty() && self.norm.is_empty() {
            return;
        }
        // Right-hand sides belong to a step that starts at the trial: R·step makes them those of one from here.
        let (rows, mut right) = (self.program.rows.clone(), self.program.right.clone());
        self.fill_constraints(ocp, trial, 0..self.path.len(), 0..self.norm.len());
        self.program.rows.clone_from(&rows);
        let mut step = z.to_vec();
        for s in &self.slacks {
            step[s.variable] = 0.0;
        }
        for (&(row, variable), r) in self.program.row_places.iter().zip(&rows) {
            self.program.right[row] += r * step[variable];
        }
        // The other rows are linear.
        let curved = self.path.iter().flat_map(|c| c.sides.iter().map(|s| s.1..s.1 + 1));
        let curved = curved
            .chain(self.norm.iter().map(|c| c.row..c.row + 1 + ocp.norm_constraints[c.constraint].vector.outputs()));
        for rows in curved {
            right[rows.clone()].copy_from_slice(&self.program.right[rows]);
        }
        self.program.right = right;
    }

    /// Sets the Hessian to the proximal term.
    fn fill_curvature(&mut self, ocp: &Ocp, proximal: f64) {
        let p = &mut self.program;
        p.hessian.fill(0.0);
        if proximal == 0.0 {
            return;
        }
        for k in 0..=p.steps {
            for i in (0..p.states).filter(|_| k > 0) {
                let variable = p.state(k, i);
                p.hessian[variable] = proximal * ocp.dt / ocp.state_trust[i].powi(2);
            }
            for j in (0..p.inputs).filter(|_| k < p.steps) {
                let variable = p.input(k, j);
                p.hessian[variable] = proximal * ocp.dt / ocp.input_trust[j].powi(2);
            }
        }
    }

    pub(super) fn add_stage_cost(&mut self, ocp: &mut Ocp, at: LinearizationPoint<'_>, k: usize) {
        let LinearizationPoint { k0, trajectory, lin } = at;
        let w = self.program.states + self.program.inputs;
        let Some(mut cost) = ocp.stage.take() else {
            if let Some(blocks) = &mut self.blocks {
                blocks.note(k, w, lin, None);
            }
            return;
        };
        self.gradient.fill(0.0);
        self.hessian.clear();
        self.hessian.resize(cost.hessian_pattern().len(), 0.0);
        let r = &ocp.reference(ocp.sample(k0, k))[..cost.references()];
        let (t, length) = (ocp.time(k0, k), ocp.length(k));
        let (x, u) = (trajectory.x(k), trajectory.u(k));
        cost.add_derivatives(CostPoint { x, u, t, r }, length, &mut self.gradient, &mut self.hessian);
        for (v, g) in self.gradient.iter().enumerate() {
            if let Some(variable) = self.program.variable(k, self.moves.place(k, v)) {
                self.program.gradient[variable] += g;
            }
        }
        for (&slot, h) in self.stage_slots[k].iter().zip(&self.hessian) {
            if slot != NOWHERE {
                self.program.hessian[slot] += h;
            }
        }
        if let Some(blocks) = &mut self.blocks {
            blocks.note(k, w, lin, Some((&cost, length, &self.hessian)));
        }
        ocp.stage = Some(cost);
    }

    pub(super) fn add_end_cost(
        &mut self,
        ocp: &mut Ocp,
        LinearizationPoint { k0, trajectory, .. }: LinearizationPoint<'_>,
    ) {
        let (n, steps) = (self.program.states, self.program.steps);
        if let Some(mut cost) = ocp.terminal.take() {
            self.gradient.fill(0.0);
            self.hessian.clear();
            self.hessian.resize(cost.hessian_pattern().len(), 0.0);
            let r = &ocp.reference(ocp.sample(k0, steps))[..cost.references()];
            let t = ocp.time(k0, steps);
            let at = CostPoint { x: trajectory.x(steps), u: &[], t, r };
            cost.add_derivatives(at, 1.0, &mut self.gradient[..n], &mut self.hessian);
            for i in 0..n {
                let variable = self.program.state(steps, i);
                self.program.gradient[variable] += self.gradient[i];
            }
            for (&slot, h) in self.terminal_slots.iter().zip(&self.hessian) {
                self.program.hessian[slot] += h;
            }
            ocp.terminal = Some(cost);
        }
        for t in &ocp.targets {
            let variable = self.program.state(steps, t.state);
            let e = trajectory.x(steps)[t.state] - t.value;
            self.program.gradient[variable] += 2.0 * t.quadratic * e;
            self.program.hessian[variable] += 2.0 * t.quadratic;
        }
    }

    fn fill_flow(
        &mut self,
        LinearizationPoint { trajectory, lin, .. }: LinearizationPoint<'_>,
        intervals: Range<usize>,
    ) {
        let p = &mut self.program;
        let (n, m) = (p.states, p.inputs);
        for k in intervals {
            for i in 0..n {
                p.defect[k * n + i] = lin.end[k * n + i] - trajectory.x(k + 1)[i];
            }
            for j in 0..m {
                let (start, shared) = (p.block_start[k * m + j], p.shared_with[k * m + j]);
                let equal = if start < k { trajectory.u(start)[j] } else { trajectory.u(k)[shared] };
                p.offset[k * m + j] = equal - trajectory.u(k)[j];
            }
        }
    }

    /// Adds the curvature of the path constraints to the exact Hessian, for the multipliers of the last program.
    pub(super) fn add_row_curvature(
        &mut self,
        ocp: &mut Ocp,
        LinearizationPoint { k0, trajectory, .. }: LinearizationPoint<'_>,
        multipliers: &[f64],
    ) {
        let Some(blocks) = &mut self.blocks else { return };
        for rows in self.path.iter().filter(|rows| rows.k < self.program.steps) {
            let signed = |(upper, row, _): &(bool, usize, Vec<usize>)| {
                let y = multipliers.get(*row).copied().unwrap_or(0.0);
                if *upper { y } else { -y }
            };
            let weight: f64 = rows.sides.iter().map(signed).sum();
            if weight != 0.0 {
                let k = rows.k;
                let at = (ocp.sample(k0, k), ocp.time(k0, k));
                let block = blocks.exact_block(k, self.program.states + self.program.inputs);
                ocp.add_row_curvature(rows.constraint, at, (trajectory.x(k), trajectory.u(k)), weight, block);
                carry_block(self.moves.at(k), self.program.states + self.program.inputs, block);
            }
        }
    }

    /// Notes the bounds that the last program held: what they bound does not move, whatever its curvature is.
    fn note_active_bounds(&mut self, multipliers: &[f64]) {
        let Some(blocks) = &mut self.blocks else { return };
        blocks.held.clear();
        let (p, n) = (&self.program, self.program.states);
        let inputs = self.input_rows.iter().map(|r| (r, n + r.of));
        let states = self.state_rows.iter().filter(|r| r.k < p.steps).map(|r| (r, r.of));
        // A soft bound that is violated holds nothing: its distance is negative.
        let curvature_of = |row: usize| {
            let (y, size) = (multipliers.get(row).copied().unwrap_or(0.0), p.row_scale[row]);
            (y > 0.0 && p.right[row].abs() < ACTIVE * size).then(|| y / p.right[row].max(NEAR * size))
        };
        for (r, variable) in inputs.chain(states) {
            if let Some(curvature) = curvature_of(r.row) {
                blocks.held.add(r.k, std::iter::once((variable, 1.0)), curvature);
            }
        }
        for rows in self.path.iter().filter(|rows| rows.k < p.steps) {
            for (_, row, slots) in &rows.sides {
                if let Some(curvature) = curvature_of(*row) {
                    let slots = slots.iter().filter(|slot| **slot != NOWHERE);
                    let gradient = slots.map(|&slot| (p.place_at(rows.k, p.row_places[slot].1), p.rows[slot]));
                    blocks.held.add(rows.k, gradient, curvature);
                }
            }
        }
    }

    pub(super) fn fill_bounds(&mut self, ocp: &Ocp, trajectory: &PlannedTrajectory) {
        let right = &mut self.program.right;
        for r in &self.input_rows {
            let (v, b) = (trajectory.u(r.k)[r.of], ocp.input_bounds[r.of]);
            right[r.row] = if r.upper { b.1 - v } else { v - b.0 };
        }
        for r in &self.state_rows {
            let (v, b) = (trajectory.x(r.k)[r.of], ocp.state_bounds_at(r.k, r.of));
            right[r.row] = if r.upper { b.max - v } else { v - b.min };
        }
        for r in &self.target_rows {
            let t = &ocp.targets[r.of];
            let e = trajectory.x(r.k)[t.state] - t.value;
            right[r.row] = if r.upper { -e } else { e };
        }
    }

    /// Linearizes the path constraints and norm constraints of the given numbers.
    pub(super) fn fill_constraints(
        &mut self,
        ocp: &mut Ocp,
        at: LinearizationPoint<'_>,
        path: Range<usize>,
        norm: Range<usize>,
    ) {
        let LinearizationPoint { k0, trajectory, .. } = at;
        let steps = self.program.steps;
        let input = |k: usize| if k < steps { trajectory.u(k) } else { &[] };
        let program = &mut self.program;
        for rows in &self.path[path] {
            let k = rows.k;
            let at = (ocp.sample(k0, k), ocp.time(k0, k));
            let margin = ocp.path_margin(rows.constraint, k);
            ocp.row_function_at(rows.constraint, at, (trajectory.x(k), input(k)), |bounds, g, jacobian| {
                for (upper, row, slots) in &rows.sides {
                    let sign = if *upper { 1.0 } else { -1.0 };
                    let bounds = bounds.within(margin);
                    program.right[*row] = if *upper { bounds.max - g } else { g - bounds.min };
                    set_entries(&mut program.rows, slots, jacobian, sign);
                }
            });
        }
        let mut constraints = std::mem::take(&mut ocp.norm_constraints);
        for rows in &self.norm[norm] {
            let k = rows.k;
            let c = &mut constraints[rows.constraint];
            let (r, t) = (ocp.reference(ocp.sample(k0, k)), ocp.time(k0, k));
            let (h, jacobian) = c.limit.values_and_jacobian(trajectory.x(k), input(k), t, r);
            self.program.right[rows.row] = h[0];
            set_entries(&mut self.program.rows, &rows.limit, jacobian, -1.0);
            let (g, jacobian) = c.vector.values_and_jacobian(trajectory.x(k), input(k), t, r);
            self.program.right[rows.row + 1..][..g.len()].copy_from_slice(g);
            set_entries(&mut self.program.rows, &rows.vector, jacobian, -1.0);
        }
        ocp.norm_constraints = constraints;
    }
}

fn set_entries(values: &mut [f64], slots: &[usize], jacobian: &[f64], sign: f64) {
    for (&slot, v) in slots.iter().zip(jacobian) {
        if slot != NOWHERE {
            values[slot] = sign * v;
        }
    }
}
