//! Layout of the stage program: which variables, rows and places there are.

use super::exact_hessian::{StageBlocks, block_places};
use super::program::{NOWHERE, Side, StageProgram};
use crate::ocp::{Moves, Ocp, Softness};

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
#[derive(Default)]
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
    pub(super) moves: Moves,
}

/// A slack of the bound, constraint or target number `of`: its grid point and its place there.
struct SlackPlace {
    of: usize,
    k: usize,
    place: usize,
}

/// The slacks of a horizon by what they soften, and their number at each grid point.
struct Slacks {
    counts: Vec<usize>,
    states: Vec<SlackPlace>,
    path: Vec<SlackPlace>,
    norm: Vec<SlackPlace>,
    targets: Vec<SlackPlace>,
    set: Option<SlackPlace>,
}

impl Slacks {
    fn new(ocp: &Ocp, steps: usize) -> Self {
        let mut counts = vec![0; steps + 1];
        let mut add = |of: usize, k: usize| {
            counts[k] += 1;
            SlackPlace { of, k, place: counts[k] - 1 }
        };
        let bounded: Vec<usize> = (0..ocp.states()).filter(|&i| !ocp.state_bounds[i].is_free()).collect();
        let mut states = Vec::new();
        for k in 1..=steps {
            states.extend(bounded.iter().map(|&i| add(i, k)));
        }
        let mut path = Vec::new();
        for (c, (_, points, _)) in ocp.row_functions(steps).enumerate().filter(|(_, (p, ..))| !p.bounds.is_free()) {
            path.extend(points.map(|k| add(c, k)));
        }
        let mut norm = Vec::new();
        for (c, p) in ocp.norm_constraints.iter().enumerate() {
            norm.extend(p.grid_points(steps).map(|k| add(c, k)));
        }
        let linear = (0..ocp.targets.len()).filter(|&j| ocp.targets[j].linear > 0.0);
        let targets = linear.map(|j| add(j, steps)).collect();
        let set = ocp.terminal_set.as_ref().map(|_| add(0, steps));
        Self { counts, states, path, norm, targets, set }
    }

    /// The program with its variables, without rows.
    fn program(&self, ocp: &Ocp, steps: usize, closure: &[bool]) -> StageProgram {
        let (n, m) = (ocp.states(), ocp.inputs());
        let mut first = vec![0; steps + 1];
        for k in 1..=steps {
            first[k] = first[k - 1] + self.counts[k - 1] + m + if k > 1 { n } else { 0 };
        }
        let variables = first[steps] + self.counts[steps] + if steps > 0 { n } else { 0 };
        StageProgram {
            states: n,
            inputs: m,
            steps,
            flow_pattern: closure.to_vec(),
            first,
            slacks: self.counts.clone(),
            defect: vec![0.0; steps * n],
            block_start: ocp.block_starts(steps),
            shared_with: ocp.shared_inputs(steps),
            offset: vec![0.0; steps * m],
            hessian_places: (0..variables).map(|v| (v, v)).collect(),
            gradient: vec![0.0; variables],
            ..StageProgram::default()
        }
    }
}

/// The sides of an interval that bound something, the upper one first: whether it is the upper one.
fn sides(min: f64, max: f64) -> impl Iterator<Item = bool> {
    [(true, max), (false, min)].into_iter().filter(|side| side.1.is_finite()).map(|side| side.0)
}

impl Assembly {
    /// Lays out the program for a horizon of `steps` intervals; `closure` marks the possible entries of ∂F/∂(x, u), `exact`
    /// makes room for the exact Hessian.
    pub(super) fn new(ocp: &Ocp, steps: usize, closure: &[bool], exact: bool) -> Self {
        let slacks = Slacks::new(ocp, steps);
        let mut assembly = Self {
            program: slacks.program(ocp, steps, closure),
            blocks: exact.then(|| StageBlocks::new(ocp.moves())),
            gradient: vec![0.0; ocp.states() + ocp.inputs()],
            moves: ocp.moves(),
            ..Self::default()
        };
        assembly.bound_inputs(ocp);
        assembly.bound_states(ocp, &slacks.states);
        assembly.add_path_constraints(ocp, &slacks.path);
        assembly.add_targets(ocp, &slacks.targets);
        for at in &slacks.norm {
            assembly.add_slack(at, ocp.norm_constraints[at.of].softness, ocp.share(at.k), 1.0);
        }
        let set = ocp.terminal_set.as_ref().zip(slacks.set.as_ref());
        if let Some((set, at)) = set {
            assembly.add_slack(at, set.softness, 1.0, set.level.sqrt());
        }
        assembly.program.nonnegative = assembly.program.right.len();
        assembly.add_norm_cones(ocp, &slacks.norm);
        if let Some((set, at)) = set {
            assembly.add_terminal_cone(set.root(), at);
        }
        assembly.pair_rows();
        assembly.place_second_derivatives(ocp);
        assembly.set_scales(ocp);
        assembly
    }

    /// Notes which rows bound one function from both sides.
    fn pair_rows(&mut self) {
        let sides = &mut self.program.sides;
        for bounds in [&self.input_rows, &self.state_rows, &self.target_rows] {
            for pair in bounds.windows(2).filter(|pair| (pair[0].k, pair[0].of) == (pair[1].k, pair[1].of)) {
                sides[pair[1].row] = Side::OppositeOf(pair[0].row);
            }
        }
        for rows in &self.path {
            if let [first, second] = rows.sides.as_slice() {
                sides[second.1] = Side::OppositeOf(first.1);
            }
        }
    }

    fn bound_inputs(&mut self, ocp: &Ocp) {
        for k in 0..self.program.steps {
            for (j, b) in ocp.input_bounds.iter().enumerate() {
                for upper in sides(b.0, b.1) {
                    let row = self.program.add_bound(k, self.program.input(k, j), upper, None);
                    self.input_rows.push(BoundRow { k, of: j, upper, row });
                }
            }
        }
    }

    fn bound_states(&mut self, ocp: &Ocp, slacks: &[SlackPlace]) {
        for at in slacks {
            let (k, of, b) = (at.k, at.of, &ocp.state_bounds[at.of]);
            let slack = self.program.slack(k, at.place);
            for upper in sides(b.min, b.max) {
                let row = self.program.add_bound(k, self.program.state(k, of), upper, Some(slack));
                self.state_rows.push(BoundRow { k, of, upper, row });
            }
            self.add_slack(at, b.softness, ocp.share(at.k), ocp.state_scale[of]);
        }
    }

    fn add_path_constraints(&mut self, ocp: &Ocp, slacks: &[SlackPlace]) {
        let functions: Vec<_> = ocp.row_functions(self.program.steps).collect();
        for at in slacks {
            let (k, (p, _, over_time)) = (at.k, &functions[at.of]);
            let slack = self.program.slack(k, at.place);
            let rows = sides(p.bounds.min, p.bounds.max).map(|upper| {
                let row = self.program.add_row(k);
                self.program.add_entry(row, slack, -1.0);
                (upper, row, self.program.add_jacobian(row, k, p.function.jacobian_pattern(), &self.moves))
            });
            let sides = rows.collect();
            self.path.push(PathRows { constraint: at.of, k, sides });
            self.add_slack(at, p.bounds.softness, if *over_time { ocp.share(k) } else { 1.0 }, 1.0);
        }
    }

    /// The rows of the targets' linear weights, whose slacks need no bound of their own.
    fn add_targets(&mut self, ocp: &Ocp, slacks: &[SlackPlace]) {
        for at in slacks {
            let (k, of, t) = (at.k, at.of, &ocp.targets[at.of]);
            let variable = self.program.slack(k, at.place);
            for upper in [true, false] {
                let row = self.program.add_bound(k, self.program.state(k, t.state), upper, Some(variable));
                self.target_rows.push(BoundRow { k, of, upper, row });
            }
            let softness = Softness::Soft { linear: t.linear, quadratic: 0.0 };
            self.slacks.push(Slack { variable, softness, factor: 1.0, scale: ocp.state_scale[t.state] });
        }
    }

    /// A slack with its bound.
    fn add_slack(&mut self, at: &SlackPlace, softness: Softness, factor: f64, scale: f64) {
        let variable = self.program.slack(at.k, at.place);
        let row = self.program.add_bound(at.k, variable, false, None);
        self.program.sides[row] = Side::SlackBound;
        self.slacks.push(Slack { variable, softness, factor, scale });
    }

    fn add_norm_cones(&mut self, ocp: &Ocp, slacks: &[SlackPlace]) {
        for at in slacks {
            let (k, constraint, p) = (at.k, at.of, &ocp.norm_constraints[at.of]);
            let row = self.program.add_row(k);
            self.program.add_entry(row, self.program.slack(k, at.place), -1.0);
            let limit = self.program.add_jacobian(row, k, p.limit.jacobian_pattern(), &self.moves);
            for _ in 0..p.vector.outputs() {
                self.program.add_row(k);
            }
            let vector = self.program.add_jacobian(row + 1, k, p.vector.jacobian_pattern(), &self.moves);
            self.program.second_order.push(1 + p.vector.outputs());
            self.norm.push(NormRows { constraint, k, row, limit, vector });
        }
    }

    fn add_terminal_cone(&mut self, root: Vec<Vec<f64>>, at: &SlackPlace) {
        let p = &mut self.program;
        let first = p.add_row(at.k);
        p.add_entry(first, p.slack(at.k, at.place), -1.0);
        for w in &root {
            let row = p.add_row(at.k);
            for (i, v) in w.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                p.add_entry(row, p.state(at.k, i), -v);
            }
        }
        p.second_order.push(1 + root.len());
        self.set = Some(SetRows { row: first, root });
    }

    /// The places of the costs' second derivatives.
    fn place_second_derivatives(&mut self, ocp: &Ocp) {
        let p = &mut self.program;
        let stage_pattern = ocp.stage.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        for k in 0..p.steps {
            let stage_pattern = stage_pattern.iter().map(|&(i, j)| (self.moves.place(k, i), self.moves.place(k, j)));
            let stage_pattern: Vec<(usize, usize)> = stage_pattern.map(|(i, j)| (i.min(j), i.max(j))).collect();
            let slots = match &mut self.blocks {
                Some(blocks) => {
                    let all: Vec<(usize, usize)> = block_places(p.states + p.inputs).collect();
                    let slots = places(p, k, &all);
                    let of_cost = stage_pattern.iter().filter_map(|p| all.iter().position(|a| a == p));
                    let of_cost = of_cost.map(|i| slots[i]).collect();
                    blocks.slots.push(slots);
                    of_cost
                }
                None => places(p, k, &stage_pattern),
            };
            self.stage_slots.push(slots);
        }
        let terminal_pattern = ocp.terminal.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        self.terminal_slots = places(p, p.steps, terminal_pattern);
        p.hessian = vec![0.0; p.hessian_places.len()];
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
                let mut sizes = [half, ocp.input_trust[j]];
                if ocp.constant_inputs.contains(&j) {
                    sizes.reverse();
                }
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

    /// Moves the multipliers of path constraints on by one grid point; the last ones are kept.
    pub(super) fn shift_rows(&self, multipliers: &mut [f64]) {
        // The grid points of a constraint stand in order.
        for pair in self.path.windows(2).filter(|pair| pair[0].constraint == pair[1].constraint) {
            for (&(_, row, _), &(_, after, _)) in pair[0].sides.iter().zip(&pair[1].sides) {
                if let Some(&y) = multipliers.get(after) {
                    multipliers[row] = y;
                }
            }
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

impl StageProgram {
    fn add_row(&mut self, k: usize) -> usize {
        self.right.push(0.0);
        self.row_stage.push(k);
        self.sides.push(Side::First);
        self.right.len() - 1
    }

    fn add_entry(&mut self, row: usize, variable: usize, value: f64) -> usize {
        self.row_places.push((row, variable));
        self.rows.push(value);
        self.rows.len() - 1
    }

    /// ± variable − slack ≤ …
    fn add_bound(&mut self, k: usize, variable: usize, upper: bool, slack: Option<usize>) -> usize {
        let row = self.add_row(k);
        self.add_entry(row, variable, if upper { 1.0 } else { -1.0 });
        if let Some(s) = slack {
            self.add_entry(row, s, -1.0);
        }
        row
    }

    /// Slots of a Jacobian whose first row is `row`.
    fn add_jacobian(&mut self, row: usize, k: usize, pattern: &[(usize, usize)], moves: &Moves) -> Vec<usize> {
        // A constant input is a variable of its own here; the state that carries it on has other entries.
        let place = |j: usize| if k == 0 { moves.place(k, j) } else { j };
        let entry =
            |&(i, j): &(usize, usize)| self.variable(k, place(j)).map_or(NOWHERE, |v| self.add_entry(row + i, v, 0.0));
        pattern.iter().map(entry).collect()
    }
}
