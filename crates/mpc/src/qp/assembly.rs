//! Filling the stage program from the problem.

use super::program::StageProgram;
use crate::ocp::{Ocp, Softness};
use crate::shooting::Linearisation;
use crate::trajectory::Trajectory;

/// Smallest curvature of any variable, in units of its size and of the objective: keeps the program strictly convex.
const REGULARISATION: f64 = 1e-9;

/// Smallest unit of the objective.
const SMALLEST_OBJECTIVE: f64 = 1e-12;

/// An entry that stands nowhere: x_0 does not change.
const NOWHERE: usize = usize::MAX;

/// A bound of one variable: row, whether it is the upper one.
struct BoundRow {
    k: usize,
    of: usize,
    upper: bool,
    row: usize,
}

/// What a slack costs.
#[derive(Clone, Copy)]
struct Slack {
    variable: usize,
    softness: Softness,
    /// dt along the horizon, 1 at its end.
    factor: f64,
    /// Violations of hard constraints are measured in it.
    scale: f64,
}

/// A path constraint at one grid point: its rows (upper, lower) with the slots of its Jacobian.
struct PathRows {
    constraint: usize,
    k: usize,
    sides: Vec<(bool, usize, Vec<usize>)>,
}

/// A norm constraint at one grid point: its first row, the slots of the Jacobians of limit and vector.
struct NormRows {
    constraint: usize,
    k: usize,
    row: usize,
    limit: Vec<usize>,
    vector: Vec<usize>,
}

/// The terminal set: its first row, W with WᵀW = P.
struct SetRows {
    row: usize,
    root: Vec<Vec<f64>>,
}

/// Where the parts of the problem stand in the program.
pub(super) struct Assembly {
    pub(super) program: StageProgram,
    stage_slots: Vec<Vec<usize>>,
    terminal_slots: Vec<usize>,
    input_rows: Vec<BoundRow>,
    state_rows: Vec<BoundRow>,
    target_rows: Vec<BoundRow>,
    slacks: Vec<Slack>,
    path: Vec<PathRows>,
    norm: Vec<NormRows>,
    set: Option<SetRows>,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
}

/// Numbers of slacks and their places while the program is laid out.
struct Slacks {
    counts: Vec<usize>,
}

impl Slacks {
    fn add(&mut self, k: usize) -> (usize, usize) {
        self.counts[k] += 1;
        (k, self.counts[k] - 1)
    }
}

impl Assembly {
    /// Lays out the program for a horizon of `steps` intervals; `closure` marks the possible entries of ∂F/∂(x, u).
    pub(super) fn new(ocp: &Ocp, steps: usize, closure: &[bool]) -> Self {
        let (n, m) = (ocp.states(), ocp.inputs());
        // First pass: which slacks there are.
        let mut slacks = Slacks { counts: vec![0; steps + 1] };
        let bounded: Vec<usize> = (0..n).filter(|&i| !ocp.state_bounds[i].is_free()).collect();
        let mut state_slacks = Vec::new();
        for k in 1..=steps {
            for &i in &bounded {
                state_slacks.push((k, i, slacks.add(k)));
            }
        }
        let mut path_slacks = Vec::new();
        for (c, p) in ocp.path_constraints.iter().enumerate().filter(|(_, p)| !p.bounds.is_free()) {
            path_slacks.extend(p.grid_points(steps).map(|k| (c, k, slacks.add(k))));
        }
        let mut norm_slacks = Vec::new();
        for (c, p) in ocp.norm_constraints.iter().enumerate() {
            norm_slacks.extend(p.grid_points(steps).map(|k| (c, k, slacks.add(k))));
        }
        let linear_targets: Vec<_> =
            (0..ocp.targets.len()).filter(|&j| ocp.targets[j].linear > 0.0).map(|j| (j, slacks.add(steps))).collect();
        let set_slack = ocp.terminal_set.as_ref().map(|s| (s, slacks.add(steps)));

        let mut first = vec![0; steps + 1];
        for k in 1..=steps {
            first[k] = first[k - 1] + slacks.counts[k - 1] + m + if k > 1 { n } else { 0 };
        }
        let variables = first[steps] + slacks.counts[steps] + if steps > 0 { n } else { 0 };
        let mut program = StageProgram {
            states: n,
            inputs: m,
            steps,
            flow_pattern: closure.to_vec(),
            first,
            slacks: slacks.counts,
            defect: vec![0.0; steps * n],
            block_start: ocp.block_starts(steps),
            offset: vec![0.0; steps * m],
            hessian_places: (0..variables).map(|v| (v, v)).collect(),
            gradient: vec![0.0; variables],
            ..StageProgram::default()
        };

        // Second pass: rows, those of the orthant first.
        let mut rows = Rows { program: &mut program };
        let mut assembled = Self {
            program: StageProgram::default(),
            stage_slots: Vec::new(),
            terminal_slots: Vec::new(),
            input_rows: Vec::new(),
            state_rows: Vec::new(),
            target_rows: Vec::new(),
            slacks: Vec::new(),
            path: Vec::new(),
            norm: Vec::new(),
            set: None,
            gradient: vec![0.0; n + m],
            hessian: Vec::new(),
        };
        for k in 0..steps {
            for (j, b) in ocp.input_bounds.iter().enumerate() {
                for (upper, limit) in [(true, b.1), (false, b.0)] {
                    if limit.is_finite() {
                        let row = rows.bound(k, rows.program.input(k, j), upper, None);
                        assembled.input_rows.push(BoundRow { k, of: j, upper, row });
                    }
                }
            }
        }
        for &(k, i, (_, place)) in &state_slacks {
            let b = &ocp.state_bounds[i];
            let slack = rows.program.slack(k, place);
            for (upper, limit) in [(true, b.max), (false, b.min)] {
                if limit.is_finite() {
                    let row = rows.bound(k, rows.program.state(k, i), upper, Some(slack));
                    assembled.state_rows.push(BoundRow { k, of: i, upper, row });
                }
            }
            rows.bound(k, slack, false, None);
            let (softness, scale) = (b.softness, ocp.state_scale[i]);
            assembled.slacks.push(Slack { variable: slack, softness, factor: ocp.dt, scale });
        }
        for &(c, k, (_, place)) in &path_slacks {
            let p = &ocp.path_constraints[c];
            let slack = rows.program.slack(k, place);
            let mut sides = Vec::new();
            for (upper, limit) in [(true, p.bounds.max), (false, p.bounds.min)] {
                if limit.is_finite() {
                    let row = rows.row(k);
                    rows.entry(row, slack, -1.0);
                    sides.push((upper, row, rows.jacobian(row, k, p.function.jacobian_pattern())));
                }
            }
            assembled.path.push(PathRows { constraint: c, k, sides });
            rows.bound(k, slack, false, None);
            let softness = p.bounds.softness;
            assembled.slacks.push(Slack { variable: slack, softness, factor: ocp.dt, scale: 1.0 });
        }
        for &(j, (k, place)) in &linear_targets {
            let slack = rows.program.slack(k, place);
            let t = &ocp.targets[j];
            for upper in [true, false] {
                let row = rows.bound(k, rows.program.state(k, t.state), upper, Some(slack));
                assembled.target_rows.push(BoundRow { k, of: j, upper, row });
            }
            let softness = Softness::Soft { linear: t.linear, quadratic: 0.0 };
            let scale = ocp.state_scale[t.state];
            assembled.slacks.push(Slack { variable: slack, softness, factor: 1.0, scale });
        }
        for &(c, k, (_, place)) in &norm_slacks {
            let slack = rows.program.slack(k, place);
            rows.bound(k, slack, false, None);
            let softness = ocp.norm_constraints[c].softness;
            assembled.slacks.push(Slack { variable: slack, softness, factor: ocp.dt, scale: 1.0 });
        }
        if let Some((set, (k, place))) = set_slack {
            let slack = rows.program.slack(k, place);
            rows.bound(k, slack, false, None);
            let (softness, scale) = (set.softness, set.level.sqrt());
            assembled.slacks.push(Slack { variable: slack, softness, factor: 1.0, scale });
        }
        rows.program.nonnegative = rows.program.right.len();
        for &(c, k, (_, place)) in &norm_slacks {
            let p = &ocp.norm_constraints[c];
            let slack = rows.program.slack(k, place);
            let row = rows.row(k);
            rows.entry(row, slack, -1.0);
            let limit = rows.jacobian(row, k, p.limit.jacobian_pattern());
            for _ in 0..p.vector.outputs() {
                rows.row(k);
            }
            let vector = rows.jacobian(row + 1, k, p.vector.jacobian_pattern());
            rows.program.second_order.push(1 + p.vector.outputs());
            assembled.norm.push(NormRows { constraint: c, k, row, limit, vector });
        }
        if let Some((set, (k, place))) = set_slack {
            let slack = rows.program.slack(k, place);
            let row = rows.row(k);
            rows.entry(row, slack, -1.0);
            let root = set.root();
            for w in &root {
                let row = rows.row(k);
                for (i, v) in w.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                    let variable = rows.program.state(k, i);
                    rows.entry(row, variable, -v);
                }
            }
            rows.program.second_order.push(1 + root.len());
            assembled.set = Some(SetRows { row, root });
        }

        // The places of the costs' second derivatives.
        let stage_pattern = ocp.stage.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        for k in 0..steps {
            assembled.stage_slots.push(places(&mut program, k, stage_pattern));
        }
        let terminal_pattern = ocp.terminal.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        assembled.terminal_slots = places(&mut program, steps, terminal_pattern);
        program.hessian = vec![0.0; program.hessian_places.len()];
        assembled.program = program;
        assembled.set_scales(ocp);
        assembled
    }

    /// Sizes: of states as the problem states them, of inputs half the distance of their bounds, else their trust.
    fn set_scales(&mut self, ocp: &Ocp) {
        let p = &mut self.program;
        p.scale = vec![1.0; p.variables()];
        p.row_scale = vec![1.0; p.right.len()];
        for k in 0..=p.steps {
            for i in (0..p.states).filter(|_| k > 0) {
                let v = p.state(k, i);
                p.scale[v] = ocp.state_scale[i];
            }
            for j in (0..p.inputs).filter(|_| k < p.steps) {
                let v = p.input(k, j);
                let half = (ocp.input_bounds[j].1 - ocp.input_bounds[j].0) / 2.0;
                let sizes = [half, ocp.input_trust[j]];
                p.scale[v] = sizes.into_iter().find(|s| s.is_finite() && *s > 0.0).unwrap_or(1.0);
            }
        }
        for s in &self.slacks {
            p.scale[s.variable] = s.scale;
        }
        // The first entry of a bound is the variable that it bounds.
        for &(row, variable) in p.row_places.iter().rev().filter(|(row, _)| *row < p.nonnegative) {
            p.row_scale[row] = p.scale[variable];
        }
        for rows in &self.path {
            rows.sides.iter().for_each(|&(_, row, _)| p.row_scale[row] = 1.0);
        }
        if let (Some(rows), Some(set)) = (&self.set, &ocp.terminal_set) {
            p.row_scale[rows.row..].fill(set.level.sqrt());
        }
    }

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

    fn regularise(&mut self, v: usize) {
        let p = &mut self.program;
        p.hessian[v] += REGULARISATION * p.objective_scale / p.scale[v].powi(2);
    }

    /// Fills in every number; see [`Qp::assemble`](super::Qp::assemble).
    pub(super) fn fill(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &Trajectory,
        lin: &Linearisation,
        proximal: f64,
        hard: f64,
    ) {
        let steps = self.program.steps;
        self.fill_curvature(ocp, proximal, 0..steps);
        self.program.gradient.fill(0.0);
        for s in &self.slacks {
            let (linear, quadratic) = s.softness.weights(s.factor, hard / s.scale);
            self.program.gradient[s.variable] = linear;
            self.program.hessian[s.variable] += 2.0 * quadratic;
        }
        for k in 0..steps {
            self.add_stage_cost(ocp, k0, k, trajectory);
        }
        self.add_end_cost(ocp, k0, trajectory);
        self.choose_objective_scale();
        for v in 0..self.program.variables() {
            self.regularise(v);
        }
        self.fill_flow(trajectory, lin, 0..steps);
        self.fill_bounds(ocp, trajectory);
        self.fill_constraints(ocp, k0, trajectory, 0..self.path.len(), 0..self.norm.len());
        if let (Some(rows), Some(set)) = (&self.set, &ocp.terminal_set) {
            self.program.right[rows.row] = set.level.sqrt();
            let x = trajectory.x(steps);
            for (i, w) in rows.root.iter().enumerate() {
                self.program.right[rows.row + 1 + i] =
                    w.iter().zip(x).zip(&set.centre).map(|((w, x), c)| w * (x - c)).sum();
            }
        }
    }

    /// Replaces the numbers of the first interval alone, after its state has become known.
    pub(super) fn fill_first(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &Trajectory,
        lin: &Linearisation,
        proximal: f64,
    ) {
        self.fill_curvature(ocp, proximal, 0..1);
        for j in 0..self.program.inputs {
            let variable = self.program.input(0, j);
            self.program.gradient[variable] = 0.0;
        }
        self.add_stage_cost(ocp, k0, 0, trajectory);
        for j in 0..self.program.inputs {
            self.regularise(self.program.input(0, j));
        }
        self.fill_flow(trajectory, lin, 0..1);
        for i in 0..self.path.len() {
            if self.path[i].k == 0 {
                self.fill_constraints(ocp, k0, trajectory, i..i + 1, 0..0);
            }
        }
        for i in 0..self.norm.len() {
            if self.norm[i].k == 0 {
                self.fill_constraints(ocp, k0, trajectory, 0..0, i..i + 1);
            }
        }
    }

    /// Sets the Hessian to the proximal term; for the first interval alone, only that of its inputs.
    fn fill_curvature(&mut self, ocp: &Ocp, proximal: f64, intervals: std::ops::Range<usize>) {
        let p = &mut self.program;
        if intervals.len() == p.steps {
            p.hessian.fill(0.0);
        } else {
            for &slot in self.stage_slots[0].iter().filter(|s| **s != NOWHERE) {
                p.hessian[slot] = 0.0;
            }
            for j in 0..p.inputs {
                let variable = p.input(0, j);
                p.hessian[variable] = 0.0;
            }
        }
        if proximal == 0.0 {
            return;
        }
        for k in intervals.clone() {
            for j in 0..p.inputs {
                let variable = p.input(k, j);
                p.hessian[variable] += proximal * ocp.dt / ocp.input_trust[j].powi(2);
            }
        }
        if intervals.len() == p.steps {
            for k in 1..=p.steps {
                for i in 0..p.states {
                    let variable = p.state(k, i);
                    p.hessian[variable] += proximal * ocp.dt / ocp.state_trust[i].powi(2);
                }
            }
        }
    }

    fn add_stage_cost(&mut self, ocp: &mut Ocp, k0: usize, k: usize, trajectory: &Trajectory) {
        let Some(mut cost) = ocp.stage.take() else { return };
        self.gradient.fill(0.0);
        self.hessian.clear();
        self.hessian.resize(cost.hessian_pattern().len(), 0.0);
        let r = &ocp.reference(k0 + k)[..cost.references()];
        let t = (k0 + k) as f64 * ocp.dt;
        let (x, u) = (trajectory.x(k), trajectory.u(k));
        cost.add_derivatives(x, u, t, r, ocp.dt, &mut self.gradient, &mut self.hessian);
        for (v, g) in self.gradient.iter().enumerate() {
            if let Some(variable) = self.program.variable(k, v) {
                self.program.gradient[variable] += g;
            }
        }
        for (&slot, h) in self.stage_slots[k].iter().zip(&self.hessian) {
            if slot != NOWHERE {
                self.program.hessian[slot] += h;
            }
        }
        ocp.stage = Some(cost);
    }

    fn add_end_cost(&mut self, ocp: &mut Ocp, k0: usize, trajectory: &Trajectory) {
        let (n, steps) = (self.program.states, self.program.steps);
        if let Some(mut cost) = ocp.terminal.take() {
            self.gradient.fill(0.0);
            self.hessian.clear();
            self.hessian.resize(cost.hessian_pattern().len(), 0.0);
            let r = &ocp.reference(k0 + steps)[..cost.references()];
            let t = (k0 + steps) as f64 * ocp.dt;
            cost.add_derivatives(trajectory.x(steps), &[], t, r, 1.0, &mut self.gradient[..n], &mut self.hessian);
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

    fn fill_flow(&mut self, trajectory: &Trajectory, lin: &Linearisation, intervals: std::ops::Range<usize>) {
        let p = &mut self.program;
        let (n, m) = (p.states, p.inputs);
        for k in intervals {
            for i in 0..n {
                p.defect[k * n + i] = lin.end[k * n + i] - trajectory.x(k + 1)[i];
            }
            let start = p.block_start[k];
            for j in 0..m {
                p.offset[k * m + j] = trajectory.u(start)[j] - trajectory.u(k)[j];
            }
        }
    }

    fn fill_bounds(&mut self, ocp: &Ocp, trajectory: &Trajectory) {
        let right = &mut self.program.right;
        for r in &self.input_rows {
            let (v, b) = (trajectory.u(r.k)[r.of], ocp.input_bounds[r.of]);
            right[r.row] = if r.upper { b.1 - v } else { v - b.0 };
        }
        for r in &self.state_rows {
            let (v, b) = (trajectory.x(r.k)[r.of], &ocp.state_bounds[r.of]);
            right[r.row] = if r.upper { b.max - v } else { v - b.min };
        }
        for r in &self.target_rows {
            let t = &ocp.targets[r.of];
            let e = trajectory.x(r.k)[t.state] - t.value;
            right[r.row] = if r.upper { -e } else { e };
        }
    }

    /// Linearises the path constraints and norm constraints of the given numbers.
    fn fill_constraints(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &Trajectory,
        path: std::ops::Range<usize>,
        norm: std::ops::Range<usize>,
    ) {
        let (dt, steps) = (ocp.dt, self.program.steps);
        let input = |k: usize| if k < steps { trajectory.u(k) } else { &[] };
        let mut constraints = std::mem::take(&mut ocp.path_constraints);
        for rows in &self.path[path] {
            let k = rows.k;
            let c = &mut constraints[rows.constraint];
            let r = ocp.reference(k0 + k);
            let (g, jacobian) = c.function.values_and_jacobian(trajectory.x(k), input(k), (k0 + k) as f64 * dt, r);
            for (upper, row, slots) in &rows.sides {
                let sign = if *upper { 1.0 } else { -1.0 };
                self.program.right[*row] = if *upper { c.bounds.max - g[0] } else { g[0] - c.bounds.min };
                set_entries(&mut self.program.rows, slots, jacobian, sign);
            }
        }
        ocp.path_constraints = constraints;
        let mut constraints = std::mem::take(&mut ocp.norm_constraints);
        for rows in &self.norm[norm] {
            let k = rows.k;
            let c = &mut constraints[rows.constraint];
            let (r, t) = (ocp.reference(k0 + k), (k0 + k) as f64 * dt);
            let (h, jacobian) = c.limit.values_and_jacobian(trajectory.x(k), input(k), t, r);
            self.program.right[rows.row] = h[0];
            set_entries(&mut self.program.rows, &rows.limit, jacobian, -1.0);
            let (g, jacobian) = c.vector.values_and_jacobian(trajectory.x(k), input(k), t, r);
            self.program.right[rows.row + 1..][..g.len()].copy_from_slice(g);
            set_entries(&mut self.program.rows, &rows.vector, jacobian, -1.0);
        }
        ocp.norm_constraints = constraints;
    }

    /// Largest slack of a hard constraint in units of its scale.
    pub(super) fn relaxation(&self, z: &[f64]) -> f64 {
        let hard = self.slacks.iter().filter(|s| s.softness == Softness::Hard);
        hard.map(|s| z[s.variable] / s.scale).fold(0.0, f64::max)
    }
}

fn set_entries(values: &mut [f64], slots: &[usize], jacobian: &[f64], sign: f64) {
    for (&slot, v) in slots.iter().zip(jacobian) {
        if slot != NOWHERE {
            values[slot] = sign * v;
        }
    }
}

/// Slots of a pattern over (x, u) at grid point k in the Hessian, new ones for places off the diagonal.
fn places(program: &mut StageProgram, k: usize, pattern: &[(usize, usize)]) -> Vec<usize> {
    let place = |&(i, j): &(usize, usize)| {
        let (Some(i), Some(j)) = (program.variable(k, i), program.variable(k, j)) else { return NOWHERE };
        if i == j {
            i
        } else {
            program.hessian_places.push((i.min(j), i.max(j)));
            program.hessian_places.len() - 1
        }
    };
    pattern.iter().map(place).collect()
}

/// Rows as they are added.
struct Rows<'a> {
    program: &'a mut StageProgram,
}

impl Rows<'_> {
    fn row(&mut self, k: usize) -> usize {
        self.program.right.push(0.0);
        self.program.row_stage.push(k);
        self.program.right.len() - 1
    }

    fn entry(&mut self, row: usize, variable: usize, value: f64) -> usize {
        self.program.row_places.push((row, variable));
        self.program.rows.push(value);
        self.program.rows.len() - 1
    }

    /// ± variable − slack ≤ …
    fn bound(&mut self, k: usize, variable: usize, upper: bool, slack: Option<usize>) -> usize {
        let row = self.row(k);
        self.entry(row, variable, if upper { 1.0 } else { -1.0 });
        if let Some(s) = slack {
            self.entry(row, s, -1.0);
        }
        row
    }

    /// Slots of a Jacobian whose first row is `row`.
    fn jacobian(&mut self, row: usize, k: usize, pattern: &[(usize, usize)]) -> Vec<usize> {
        pattern
            .iter()
            .map(|&(i, j)| self.program.variable(k, j).map_or(NOWHERE, |v| self.entry(row + i, v, 0.0)))
            .collect()
    }
}
