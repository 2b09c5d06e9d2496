//! The problem as a nonlinear program: rows and slacks of the stage program, with exact second derivatives that may be indefinite.

use super::assembly::Assembly;
use super::exact_hessian::block_places;
use super::filling::LinearizationPoint;
use super::program::{NOWHERE, StageProgram};
use crate::ocp::{Moves, Ocp, Softness};
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{ShootingLinearization, carry_block};

/// A constraint c(x_k, u_k) + s ≥ 0.
pub(crate) struct NonlinearRow {
    /// Grid point.
    pub(crate) k: usize,
    /// Number of the row in the stage program.
    pub(crate) number: usize,
    /// Place among (x_k, u_k) and slot in the stage program of −∂c.
    entries: Vec<(usize, usize)>,
    /// Number of the slack s, if it has one.
    pub(crate) slack: Option<usize>,
    /// Typical size of c.
    pub(crate) scale: f64,
}

/// A slack s, which costs `linear`·s + `quadratic`·s².
pub(crate) struct NonlinearSlack {
    /// Grid point.
    pub(crate) k: usize,
    pub(crate) linear: f64,
    pub(crate) quadratic: f64,
    pub(crate) scale: f64,
    /// Rows that it softens, one or two, and the row s ≥ 0.
    pub(crate) softens: Vec<usize>,
    pub(crate) bound: Option<usize>,
}

/// Rows and slacks of a problem, and its derivatives at an iterate.
///
/// Hard constraints have no slack, unless their ends are equal: those have no interior.
pub(crate) struct NonlinearProgram {
    assembly: Assembly,
    pub(crate) rows: Vec<NonlinearRow>,
    pub(crate) slacks: Vec<NonlinearSlack>,
    /// Row (with its slack, if it has one) and weight of every absolute value of the cost.
    absolute: Vec<(usize, f64)>,
    /// Exact Hessian of the terminal cost, targets and constraints at the end, n rows of n.
    terminal: Vec<f64>,
    /// Sizes of the states.
    sizes: Vec<f64>,
    /// Which of (x, u) are inputs that cannot move. They are no variables: their bounds have no interior.
    fixed: Vec<bool>,
    /// What stands at the place of another variable is none itself.
    moves: Moves,
}

impl NonlinearProgram {
    /// Lays the problem out; `None` where it has second-order cones (see [`Ocp::with_norm_rows`]), blocks of equal inputs, branches, or
    /// constant inputs that no state carries on.
    pub(crate) fn new(ocp: &Ocp, closure: &[bool], hard: f64) -> Option<Self> {
        let (m, moves) = (ocp.inputs(), ocp.moves());
        let carried = ocp.carried();
        let constant = |j: usize| carried.iter().any(|c| c.0 == j);
        let starts = ocp.block_starts(ocp.steps);
        let blocked = starts.iter().enumerate().any(|(i, start)| *start != i / m && !constant(i % m));
        let blocked = blocked || ocp.branching.is_some();
        if blocked || !ocp.norm_constraints.is_empty() || ocp.terminal_set.is_some() {
            return None;
        }
        let assembly = Assembly::new(ocp, ocp.steps, closure, true);
        let p = &assembly.program;
        let mut slack_of = vec![None; p.variables()];
        let mut slacks = Vec::new();
        let equal = equal_hard_rows(ocp, &assembly);
        for s in &assembly.slacks {
            let kept =
                s.softness != Softness::Hard || p.row_places.iter().any(|&(row, v)| v == s.variable && equal[row]);
            if kept {
                let (linear, quadratic) = s.softness.weights(s.factor, hard / s.scale);
                slack_of[s.variable] = Some(slacks.len());
                let (softens, bound) = (Vec::new(), None);
                let scale = s.scale;
                slacks.push(NonlinearSlack { k: 0, linear, quadratic, scale, softens, bound });
            }
        }
        let mut layout = vec![(Vec::new(), None); p.right.len()];
        for (slot, &(row, variable)) in p.row_places.iter().enumerate() {
            let k = p.row_stage[row];
            let (first, inputs) = (p.slack(k, 0), p.slack(k, p.slacks[k]));
            if (first..inputs).contains(&variable) {
                layout[row].1 = slack_of[variable];
            } else {
                layout[row].0.push((p.place_at(k, variable), slot));
            }
        }
        let mut curved = vec![false; p.right.len()];
        assembly.path.iter().flat_map(|path| &path.sides).for_each(|side| curved[side.1] = true);
        let fixed: Vec<bool> = vec![false; p.states].into_iter().chain(ocp.fixed_inputs()).collect();
        let mut rows = Vec::new();
        for (number, (mut entries, slack)) in layout.into_iter().enumerate() {
            let k = p.row_stage[number];
            if !entries.is_empty() && slack.is_none() && entries.iter().all(|&(place, _)| fixed[place]) {
                // Nothing can change it.
                continue;
            }
            if k > 0 && matches!(entries.as_slice(), [(place, _)] if moves.place(k, *place) != *place) {
                // A constant is bounded where it is a variable.
                continue;
            }
            if let Some(s) = slack {
                slacks[s].k = k;
                if entries.is_empty() { slacks[s].bound = Some(rows.len()) } else { slacks[s].softens.push(rows.len()) }
            } else if entries.is_empty() {
                continue;
            }
            let scale = match entries.as_slice() {
                &[(place, _)] if place < p.states && !curved[number] => ocp.sizes()[place],
                _ => p.row_scale[number],
            };
            entries.retain(|&(place, _)| !fixed[place]);
            for (place, _) in &mut entries {
                *place = moves.place(k, *place);
            }
            rows.push(NonlinearRow { k, number, entries, slack, scale });
        }
        for s in &mut slacks {
            s.scale = s.softens.iter().map(|&row: &usize| rows[row].scale).fold(0.0, f64::max);
        }
        for row in &mut rows {
            if let Some(s) = row.slack.filter(|_| row.entries.is_empty()) {
                row.scale = slacks[s].scale;
            }
        }
        let first = ocp.path_constraints.len();
        let mut absolute = Vec::new();
        for path in assembly.path.iter().filter(|path| path.constraint >= first) {
            let row = path.sides.first().and_then(|side| rows.iter().position(|r| r.number == side.1));
            absolute.extend(row.and_then(|row| Some((row, slacks[rows[row].slack?].linear))));
        }
        let terminal = vec![0.0; p.states * p.states];
        Some(Self { assembly, rows, slacks, absolute, terminal, sizes: ocp.sizes().to_vec(), fixed, moves })
    }

    fn program(&self) -> &StageProgram {
        &self.assembly.program
    }

    /// Typical size of variable v of the list (x, u).
    pub(crate) fn size(&self, v: usize) -> f64 {
        let p = self.program();
        if v < p.states { self.sizes[v] } else { p.scale[p.input(0, v - p.states)] }
    }

    /// Whether variable v of the list (x, u) at grid point k is an input that cannot move, or a constant that a state stands for.
    pub(crate) fn is_fixed(&self, k: usize, v: usize) -> bool {
        self.fixed[v] || self.moves.place(k, v) != v
    }

    /// Number of rows of the stage program.
    pub(crate) fn all_rows(&self) -> usize {
        self.program().right.len()
    }

    /// c of every row along a trajectory, without slacks.
    pub(crate) fn values(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &PlannedTrajectory,
        lin: &ShootingLinearization,
        c: &mut Vec<f64>,
    ) {
        let all = 0..self.assembly.path.len();
        self.assembly.fill_bounds(ocp, trajectory);
        self.assembly.fill_constraints(ocp, LinearizationPoint { k0, trajectory, lin }, all, 0..0);
        c.clear();
        c.extend(self.rows.iter().map(|r| self.assembly.program.right[r.number]));
    }

    /// The part of the cost that slacks replace, for the values of the rows without slacks.
    pub(crate) fn absolute_cost(&self, c: &[f64]) -> f64 {
        self.absolute.iter().map(|&(row, weight)| weight * c[row].abs()).sum()
    }

    /// Fills in gradient, Jacobians and exact second derivatives of the Lagrangian at a trajectory that has been linearized, for
    /// these multipliers of the rows of the stage program.
    pub(crate) fn differentiate(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &PlannedTrajectory,
        lin: &ShootingLinearization,
        multipliers: &[f64],
    ) {
        let at = LinearizationPoint { k0, trajectory, lin };
        let a = &mut self.assembly;
        let (n, steps) = (a.program.states, a.program.steps);
        a.program.hessian.fill(0.0);
        a.program.gradient.fill(0.0);
        for k in 0..steps {
            a.add_stage_cost(ocp, at, k);
        }
        a.add_end_cost(ocp, at);
        a.fill_bounds(ocp, trajectory);
        a.fill_constraints(ocp, at, 0..a.path.len(), 0..0);
        a.add_row_curvature(ocp, at, multipliers);
        match &ocp.terminal {
            Some(cost) => self.terminal.copy_from_slice(cost.last_hessian()),
            None => self.terminal.fill(0.0),
        }
        for t in &ocp.targets {
            self.terminal[t.state * n + t.state] += 2.0 * t.quadratic;
        }
        let time = (k0 + steps, ocp.time(k0, steps));
        for rows in a.path.iter().filter(|rows| rows.k == steps) {
            let signed = |(upper, row, _): &(bool, usize, Vec<usize>)| {
                if *upper { multipliers[*row] } else { -multipliers[*row] }
            };
            let weight: f64 = rows.sides.iter().map(signed).sum();
            if weight != 0.0 {
                ocp.add_row_curvature(rows.constraint, time, (trajectory.x(steps), &[]), weight, &mut self.terminal);
            }
        }
    }

    /// Gradient of the cost with respect to (x_k, u_k); n entries at the end.
    pub(crate) fn add_gradient(&self, k: usize, factor: f64, to: &mut [f64]) {
        let p = self.program();
        for (v, g) in to.iter_mut().enumerate().filter(|(v, _)| !self.is_fixed(k, *v)) {
            *g += p.variable(k, v).map_or(0.0, |variable| factor * p.gradient[variable]);
        }
    }

    /// Adds `factor` times the exact block of grid point k: n + m rows of n + m, or n rows of n at the end. The curvature of an input that
    /// is no variable is 1.
    pub(crate) fn add_block(&self, k: usize, factor: f64, to: &mut [f64]) {
        let p = self.program();
        if k == p.steps {
            return to.iter_mut().zip(&self.terminal).for_each(|(t, h)| *t += factor * h);
        }
        let w = p.states + p.inputs;
        let Some(blocks) = &self.assembly.blocks else { return };
        to.iter_mut().zip(blocks.beyond_gauss_newton(k, w)).for_each(|(t, h)| *t += factor * h);
        for (&slot, (i, j)) in blocks.slots[k].iter().zip(block_places(w)).filter(|(slot, _)| **slot != NOWHERE) {
            let h = factor * p.hessian[slot];
            to[i * w + j] += h;
            if i != j {
                to[j * w + i] += h;
            }
        }
        carry_block(self.moves.at(k), w, to);
        for v in (0..w).filter(|v| self.is_fixed(k, *v)) {
            to[v * w..(v + 1) * w].fill(0.0);
            to.iter_mut().skip(v).step_by(w).for_each(|h| *h = 0.0);
            to[v * w + v] = 1.0;
        }
    }

    /// Entries (place among (x, u), value) of the gradient of row i of the list of rows.
    pub(crate) fn row(&self, i: usize) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let p = self.program();
        self.rows[i].entries.iter().map(move |&(place, slot)| (place, -p.rows[slot]))
    }
}

/// Rows of the stage program that belong to a hard constraint with equal ends.
fn equal_hard_rows(ocp: &Ocp, assembly: &Assembly) -> Vec<bool> {
    let mut equal = vec![false; assembly.program.right.len()];
    for r in &assembly.state_rows {
        let b = &ocp.state_bounds[r.of];
        equal[r.row] = b.min >= b.max;
    }
    for rows in assembly.path.iter().filter(|rows| rows.constraint < ocp.path_constraints.len()) {
        let b = &ocp.path_constraints[rows.constraint].bounds;
        rows.sides.iter().for_each(|side| equal[side.1] = b.min >= b.max);
    }
    equal
}
