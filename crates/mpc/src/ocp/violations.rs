//! Violations of path constraints, norm constraints and the terminal set along a trajectory.

use super::bounds::{Softness, Violation, ordered, positive, soft_weights};
use super::problem::Ocp;
use super::trace::Bounded;
use crate::error::{MpcError, check_length, check_value};
use crate::trajectory::PlannedTrajectory;

impl Ocp {
    /// Checks blocks, path constraints, norm constraints and the terminal set.
    pub(crate) fn check_constraints(&self, states: usize, inputs: usize) -> Result<(), MpcError> {
        if let Some(j) = self.constant_inputs.iter().find(|j| **j >= inputs) {
            return Err(MpcError::Length { what: "the list of inputs", found: inputs, expected: j + 1 });
        }
        if let Some((i, _)) = self.free_starts.iter().find(|(i, _)| *i >= states) {
            return Err(MpcError::Length { what: "the list of states", found: states, expected: i + 1 });
        }
        if let Some((_, j)) = self.free_starts.iter().find(|(_, j)| !self.constant_inputs.contains(j)) {
            let remedy = "let a constant input stand for the initial state";
            check_value(false, "the input of a free initial state", *j as f64, remedy)?;
        }
        self.check_shapes(states, inputs)?;
        for &length in &self.move_blocks {
            positive("the length of a move block", length as f64)?;
        }
        let intervals: usize = self.move_blocks.iter().sum();
        if !self.move_blocks.is_empty() && intervals < self.steps {
            return Err(MpcError::Length {
                what: "the sum of the move blocks",
                found: intervals,
                expected: self.steps,
            });
        }
        for (index, c) in self.path_constraints.iter().enumerate() {
            c.function.check("a path constraint's list of variables", states, inputs)?;
            check_length("a path constraint's function", c.function.outputs(), 1)?;
            let named = |e| match e {
                MpcError::EmptyBounds { what, index, min, max, .. } if !c.name.is_empty() => {
                    MpcError::EmptyBounds { what, index, name: Some(c.name.clone()), min, max }
                }
                e => e,
            };
            ordered("path constraint", index, c.bounds.min, c.bounds.max).map_err(named)?;
            soft_weights("a path constraint", c.bounds.softness)?;
        }
        for c in &self.norm_constraints {
            c.vector.check("a norm constraint's list of variables", states, inputs)?;
            c.limit.check("a norm constraint's list of variables", states, inputs)?;
            check_length("a norm constraint's limit", c.limit.outputs(), 1)?;
            positive("the number of components of a norm constraint", c.vector.outputs() as f64)?;
            soft_weights("a norm constraint", c.softness)?;
        }
        self.terminal_set.as_ref().map_or(Ok(()), |s| s.check(states))
    }

    /// Checks the shapes of branches, values of inputs, and margins.
    fn check_shapes(&self, states: usize, inputs: usize) -> Result<(), MpcError> {
        if !self.input_values.is_empty() {
            check_length("the list of the inputs' values", self.input_values.len(), inputs)?;
        }
        for row in &self.margins.states {
            check_length("a row of margins", row.len(), states)?;
        }
        let Some(b) = &self.branching else { return Ok(()) };
        positive("the number of branches", b.branches as f64)?;
        check_length("the list of inputs", inputs, b.branches * (inputs / b.branches))?;
        for row in &b.leaders {
            check_length("a row of leaders", row.len(), b.branches)?;
            for (branch, &leader) in row.iter().enumerate() {
                let known = leader <= branch && row[leader] == leader;
                let remedy = "name the first branch with the same past, counted from 0";
                check_value(known, format!("the leader of branch {branch}"), leader as f64, remedy)?;
            }
        }
        Ok(())
    }

    /// Largest number of references that a constraint asks for.
    pub(crate) fn constraint_references(&self) -> usize {
        let path = self.path_constraints.iter().map(|c| c.function.references());
        let norm = self.norm_constraints.iter().map(|c| c.vector.references().max(c.limit.references()));
        path.chain(norm).max().unwrap_or(0)
    }

    /// The first interval of the block that each interval belongs to, by interval and input.
    pub(crate) fn block_starts(&self, steps: usize) -> Vec<usize> {
        let start = |(k, j): (usize, usize), of_block: usize| {
            if self.constant_inputs.contains(&j) { 0 } else { of_block.min(k) }
        };
        let of_blocks = self.move_block_starts(steps);
        let rows = of_blocks.into_iter().enumerate();
        rows.flat_map(|(k, of_block)| (0..self.inputs()).map(move |j| start((k, j), of_block))).collect()
    }

    /// The first interval of the move block that each interval belongs to. A horizon that has become shorter than the blocks has
    /// lost its first intervals.
    fn move_block_starts(&self, steps: usize) -> Vec<usize> {
        if self.move_blocks.is_empty() {
            return (0..steps).collect();
        }
        let lost = self.move_blocks.iter().sum::<usize>().saturating_sub(steps);
        let mut starts = Vec::with_capacity(steps);
        let mut end = 0;
        for &length in &self.move_blocks {
            let first = end.max(lost);
            end += length;
            starts.extend((first..end).map(|_| first - lost));
        }
        starts
    }

    /// Visits the violation of every path constraint, norm constraint and of the terminal set along a trajectory that starts
    /// at grid point `k0` of the run.
    fn visit_constraints(&mut self, k0: usize, z: &PlannedTrajectory, hard: f64, mut visit: impl FnMut(Violation)) {
        let steps = z.steps();
        let input = |k: usize| if k < steps { z.u(k) } else { &[] };
        let mut path = std::mem::take(&mut self.path_constraints);
        for (number, c) in path.iter_mut().enumerate() {
            for k in c.grid_points(steps) {
                let t = self.time(k0, k);
                let g = c.function.values(z.x(k), input(k), t, self.reference(self.sample(k0, k)))[0];
                let bounds = c.bounds.within(self.path_margin(number, k));
                visit(bounds.softness.judge(bounds.violation(g), self.share(k), hard, 1.0));
            }
        }
        self.path_constraints = path;
        let mut norm = std::mem::take(&mut self.norm_constraints);
        for c in &mut norm {
            for k in c.grid_points(steps) {
                let t = self.time(k0, k);
                let r = self.reference(self.sample(k0, k));
                let g = c.vector.values(z.x(k), input(k), t, r).iter().map(|v| v * v).sum::<f64>().sqrt();
                let v = (g - c.limit.values(z.x(k), input(k), t, r)[0]).max(0.0);
                visit(c.softness.judge(v, self.share(k), hard, 1.0));
            }
        }
        self.norm_constraints = norm;
        if let Some(s) = &self.terminal_set {
            visit(s.softness.judge(s.violation(z.x(steps)), 1.0, hard, s.level.sqrt()));
        }
    }

    /// Largest violation of every soft bound and of every soft path and norm constraint along a predicted trajectory that starts at grid
    /// point `k0` of the run.
    pub(crate) fn soft_violations(&mut self, k0: usize, z: &PlannedTrajectory) -> Vec<(Bounded, f64)> {
        let soft = |softness: Softness| softness != Softness::Hard;
        let mut found = Vec::new();
        for (i, b) in self.state_bounds.iter().enumerate().filter(|(_, b)| soft(b.softness)) {
            let largest = (1..=z.steps()).map(|k| b.violation(z.x(k)[i])).fold(0.0, f64::max);
            found.push((Bounded::State(i), largest));
        }
        let margins = std::mem::take(&mut self.margins);
        let path = self.path_constraints.iter().map(|c| (c.bounds.softness, c.grid_points(z.steps()).count()));
        let norm = self.norm_constraints.iter().map(|c| (c.softness, c.grid_points(z.steps()).count()));
        let counts: Vec<_> = path.chain(norm).collect();
        let mut values = Vec::new();
        self.visit_constraints(k0, z, 0.0, |v| values.push(v.value));
        self.margins = margins;
        let mut rest = values.as_slice();
        for (c, (softness, count)) in counts.into_iter().enumerate() {
            let (own, after) = rest.split_at(count.min(rest.len()));
            rest = after;
            if soft(softness) {
                found.push((Bounded::Constraint(c), own.iter().copied().fold(0.0, f64::max)));
            }
        }
        found
    }

    /// Largest violation of a bound, path constraint, norm constraint, or the terminal set along a predicted trajectory that starts at
    /// grid point `k0` of the run, each in its own unit; NaN when a bounded value is no number.
    pub(crate) fn predicted_violation(&mut self, k0: usize, z: &PlannedTrajectory) -> f64 {
        // `f64::max` would drop a NaN.
        let worse = |worst: f64, v: f64| if worst.is_nan() || worst > v { worst } else { v };
        let mut worst = 0.0;
        // What counts are the bounds, not the margins to them.
        let margins = std::mem::take(&mut self.margins);
        self.visit_constraints(k0, z, 0.0, |v| worst = worse(worst, v.value));
        self.margins = margins;
        for k in 1..=z.steps() {
            for (v, b) in z.x(k).iter().zip(&self.state_bounds).filter(|(_, b)| !b.is_free()) {
                worst = worse(worst, if v.is_nan() { *v } else { b.violation(*v) });
            }
        }
        worst
    }

    /// Cost of violated path and norm constraints and of leaving the terminal set; hard ones at `hard` per unit of scale.
    pub(crate) fn constraint_penalty(&mut self, k0: usize, trajectory: &PlannedTrajectory, hard: f64) -> f64 {
        let mut sum = 0.0;
        self.visit_constraints(k0, trajectory, hard, |v| sum += v.cost);
        sum
    }

    /// Largest violation of a hard path or norm constraint or terminal set, in units of its scale.
    pub(crate) fn hard_constraint_violation(&mut self, k0: usize, trajectory: &PlannedTrajectory) -> f64 {
        let mut worst = 0.0_f64;
        self.visit_constraints(k0, trajectory, 0.0, |v| worst = worst.max(v.relative));
        worst
    }
}
