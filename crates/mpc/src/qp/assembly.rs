//! Layout of the stage program: which variables, rows and places there are.

use super::exact_hessian::{StageBlocks, block_places};
use super::program::{NOWHERE, StageProgram};
use crate::ocp::{Ocp, Softness};

/// A bound of one variable: row, whether it is the upper one.
pub(super) struct BoundRow {
    pub(super) k: usize,
    pub(super) of: usize,
    pub(super) upper: bool,
    pub(super) row: usize,
}

/// What a slack costs.
#[derive(Clone, Copy)]
pub(super) struct Slack {
    pub(super) variable: usize,
    pub(super) softness: Softness,
    /// dt along the horizon, 1 at its end.
    pub(super) factor: f64,
    /// Violations of hard constraints are measured in it.
    pub(super) scale: f64,
}

/// A path constraint at one grid point: its rows (upper, lower) with the slots of its Jacobian.
pub(super) struct PathRows {
    pub(super) constraint: usize,
    pub(super) k: usize,
    pub(super) sides: Vec<(bool, usize, Vec<usize>)>,
}

/// A norm constraint at one grid point: its first row, the slots of the Jacobians of limit and vector.
pub(super) struct NormRows {
    pub(super) constraint: usize,
    pub(super) k: usize,
    pub(super) row: usize,
    pub(super) limit: Vec<usize>,
    pub(super) vector: Vec<usize>,
}

/// The terminal set: its first row, W with WᵀW = P.
pub(super) struct SetRows {
    pub(super) row: usize,
    pub(super) root: Vec<Vec<f64>>,
}

/// Where the parts of the problem stand in the program.
pub(super) struct Assembly {
    pub(super) program: StageProgram,
    pub(super) stage_slots: Vec<Vec<usize>>,
    /// Blocks of the exact Hessian; without them that of the stage cost is convexified.
    pub(super) blocks: Option<StageBlocks>,
    pub(super) terminal_slots: Vec<usize>,
    pub(super) input_rows: Vec<BoundRow>,
    pub(super) state_rows: Vec<BoundRow>,
    pub(super) target_rows: Vec<BoundRow>,
    pub(super) slacks: Vec<Slack>,
    pub(super) path: Vec<PathRows>,
    pub(super) norm: Vec<NormRows>,
    pub(super) set: Option<SetRows>,
    pub(super) gradient: Vec<f64>,
    pub(super) hessian: Vec<f64>,
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
    /// Lays out the program for a horizon of `steps` intervals; `closure` marks the possible entries of ∂F/∂(x, u), `exact`
    /// makes room for the exact Hessian.
    pub(super) fn new(ocp: &Ocp, steps: usize, closure: &[bool], exact: bool) -> Self {
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
            blocks: exact.then(StageBlocks::default),
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
            let slots = match &mut assembled.blocks {
                Some(blocks) => {
                    let all: Vec<(usize, usize)> = block_places(n + m).collect();
                    let slots = places(&mut program, k, &all);
                    let of_cost =
                        stage_pattern.iter().filter_map(|p| all.iter().position(|a| a == p)).map(|i| slots[i]);
                    let of_cost = of_cost.collect();
                    blocks.slots.push(slots);
                    of_cost
                }
                None => places(&mut program, k, stage_pattern),
            };
            assembled.stage_slots.push(slots);
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

    /// Largest slack of a hard constraint in units of its scale.
    pub(super) fn relaxation(&self, z: &[f64]) -> f64 {
        let hard = self.slacks.iter().filter(|s| s.softness == Softness::Hard);
        hard.map(|s| z[s.variable] / s.scale).fold(0.0, f64::max)
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
