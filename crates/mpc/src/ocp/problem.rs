//! The optimal control problem as data.

use super::bounds::{Bounds, HARD_TOLERANCE, Softness, ordered, positive, weight};
use super::branching::Branching;
use super::constraint::{NormConstraint, PathConstraint, TerminalSet};
use super::cost::CostFunction;
use super::cost_names::CostPoint;
use super::horizon_cost::HorizonCost;
use super::margins::Margins;
use super::previous_input::PreviousInput;
use super::scaled_rows::ScaledRows;
use super::vector_function::VectorFunction;
use crate::error::{MpcError, check_length, check_value};
use crate::integrator::Integrator;
use crate::trajectory::PlannedTrajectory;
use std::ops::Range;

/// How many integration steps an interval gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Substeps {
    /// Always this many.
    Fixed(usize),
    /// At least this many, and enough that a step stays within the stability region of the method where the smoothed
    /// dynamics relax onto a switching surface.
    AtLeast(usize),
}

impl Substeps {
    /// The number given.
    pub(crate) fn least(self) -> usize {
        let (Self::Fixed(substeps) | Self::AtLeast(substeps)) = self;
        substeps
    }
}

/// A value that a state should have at the end of the horizon; a miss e costs linear·|e| + quadratic·e².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TerminalTarget {
    /// Index of the state.
    pub state: usize,
    /// The value wanted.
    pub value: f64,
    /// Weight of |e|; large enough, it makes the target exact wherever it can be reached.
    pub linear: f64,
    /// Weight of e².
    pub quadratic: f64,
}

/// An optimal control problem over N intervals of length dt. Every field is in the unit of its state or input.
#[derive(Clone)]
pub struct Ocp {
    /// Number of intervals N.
    pub steps: usize,
    /// Length of the first interval, which is the sampling period, s.
    pub dt: f64,
    /// Lengths of all intervals, s; when empty, all are dt long.
    pub lengths: Vec<f64>,
    /// Method that advances the state over an interval.
    pub integrator: Integrator,
    /// Integration steps per interval.
    pub substeps: Substeps,
    /// Integrand of the cost.
    pub stage: Option<CostFunction>,
    /// Cost of the last state; a function of the states alone.
    pub terminal: Option<CostFunction>,
    /// Values of the references, a row per grid point from [`Ocp::first_row`] on; beyond the end the last row holds.
    pub references: Vec<Vec<f64>>,
    /// Values of the live parameters of the dynamics, a row per grid point from [`Ocp::first_row`] on; beyond the end the last
    /// row holds. When empty, the dynamics keep their values.
    pub parameters: Vec<Vec<f64>>,
    /// Grid point of the run to which the first rows of references and parameters belong; before it they hold too.
    pub first_row: usize,
    /// What references and parameters are in a time that is scaled by an input.
    pub(crate) scaled_rows: Option<ScaledRows>,
    /// Bounds of every input, always hard.
    pub input_bounds: Vec<(f64, f64)>,
    /// Values that each input may take, in ascending order; none where it takes all between its bounds. Programs plan with all values
    /// between the bounds, and the controller of a [`ControlProblem`](crate::ControlProblem) rounds. When empty, no input is rounded.
    pub input_values: Vec<Vec<f64>>,
    /// Bounds of every state at the grid points 1 … N: those of the dynamics, then the previous inputs.
    pub state_bounds: Vec<Bounds>,
    /// How far within its bounds a plan is to stay.
    pub margins: Margins,
    /// Inputs whose value over the interval before follows the states of the dynamics, in this order. That before the first
    /// interval is part of the initial state.
    pub previous_inputs: Vec<PreviousInput>,
    /// Targets at the end.
    pub targets: Vec<TerminalTarget>,
    /// Functions of states and inputs that are kept within bounds.
    pub path_constraints: Vec<PathConstraint>,
    /// Vectors whose length is limited.
    pub norm_constraints: Vec<NormConstraint>,
    /// The same as smooth rows, for solutions that take second derivatives of constraints: one per norm constraint, or none.
    pub(crate) norm_rows: Vec<VectorFunction>,
    /// Numbers of intervals over which the inputs are held, in order; their sum is N. Empty: the inputs of every interval
    /// are free. A shrinking horizon loses intervals from the front of the first block.
    pub move_blocks: Vec<usize>,
    /// Inputs that are held over the whole horizon: constants to be decided on.
    pub constant_inputs: Vec<usize>,
    /// Initial states that are decided on too: the state, and the constant input whose value it has.
    pub free_starts: Vec<(usize, usize)>,
    /// Branches of a scenario tree, where the problem is one.
    pub branching: Option<Branching>,
    /// A set in which the last state shall lie.
    pub terminal_set: Option<TerminalSet>,
    /// Typical size of each state: defects are measured in it.
    pub state_scale: Vec<f64>,
    /// Size of what each state passes through, where that differs from its scale, as a target with a small tolerance does; empty: the scales.
    pub state_size: Vec<f64>,
    /// Size of a change of each state within one iteration beyond which the linearization is not trusted, for the proximal
    /// term; infinite where there is none. Velocities with dry friction need one.
    pub state_trust: Vec<f64>,
    /// The same for each input.
    pub input_trust: Vec<f64>,
}

impl Ocp {
    /// A problem without cost, bounds and targets; scales and input trusts are 1.
    pub fn new(states: usize, inputs: usize, steps: usize, dt: f64) -> Self {
        Self {
            steps,
            dt,
            lengths: Vec::new(),
            integrator: Integrator::Rk4,
            substeps: Substeps::AtLeast(1),
            stage: None,
            terminal: None,
            references: Vec::new(),
            parameters: Vec::new(),
            first_row: 0,
            scaled_rows: None,
            input_bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); inputs],
            input_values: Vec::new(),
            state_bounds: vec![Bounds::FREE; states],
            margins: Margins::default(),
            previous_inputs: Vec::new(),
            targets: Vec::new(),
            path_constraints: Vec::new(),
            norm_constraints: Vec::new(),
            norm_rows: Vec::new(),
            move_blocks: Vec::new(),
            constant_inputs: Vec::new(),
            free_starts: Vec::new(),
            branching: None,
            terminal_set: None,
            state_scale: vec![1.0; states],
            state_size: Vec::new(),
            state_trust: vec![f64::INFINITY; states],
            input_trust: vec![1.0; inputs],
        }
    }

    /// The problem with smooth rows in the place of its norm constraints, where it has them.
    pub(crate) fn with_norm_rows(mut self) -> Self {
        if self.norm_rows.len() != self.norm_constraints.len() || self.branching.is_some() {
            return self;
        }
        let norms = std::mem::take(&mut self.norm_constraints).into_iter().zip(std::mem::take(&mut self.norm_rows));
        self.path_constraints.extend(norms.map(|(norm, function)| PathConstraint {
            name: norm.name,
            function,
            bounds: Bounds { min: 0.0, max: f64::INFINITY, softness: norm.softness },
            at_end: false,
        }));
        self
    }

    /// Number of states, previous inputs included.
    pub fn states(&self) -> usize {
        self.state_bounds.len()
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.input_bounds.len()
    }

    /// The inputs closest to zero within their bounds and values.
    pub(crate) fn inputs_at_rest(&self) -> Vec<f64> {
        let closest = |values: &Vec<f64>| values.iter().copied().reduce(|a, b| if b.abs() < a.abs() { b } else { a });
        let at_rest = |(j, b): (usize, &(f64, f64))| {
            self.input_values.get(j).and_then(closest).unwrap_or_else(|| 0f64.clamp(b.0, b.1))
        };
        self.input_bounds.iter().enumerate().map(at_rest).collect()
    }

    /// Size of what each state passes through.
    pub(crate) fn sizes(&self) -> &[f64] {
        if self.state_size.is_empty() { &self.state_scale } else { &self.state_size }
    }

    /// Which inputs cannot move.
    pub(crate) fn fixed_inputs(&self) -> impl Iterator<Item = bool> + '_ {
        self.input_bounds.iter().map(|b| b.0 >= b.1)
    }

    /// Which ends of bounds are finite, and which inputs cannot move: the layout of programs depends on it.
    pub(crate) fn layout_of_bounds(&self) -> Vec<bool> {
        let states = self.state_bounds.iter().map(|b| (b.min, b.max));
        let paths = self.path_constraints.iter().map(|c| (c.bounds.min, c.bounds.max));
        let ends = states.chain(self.input_bounds.iter().copied()).chain(paths);
        ends.flat_map(|b| [b.0.is_finite(), b.1.is_finite()]).chain(self.fixed_inputs()).collect()
    }

    /// Brings every bound closer to its middle by `fraction` of the half-width (one-sided bounds stay): room for feedback.
    #[must_use]
    pub fn tightened(&self, fraction: f64) -> Self {
        let mut ocp = self.clone();
        let shrink = |min: &mut f64, max: &mut f64| {
            let half = (*max - *min) / 2.0;
            if half.is_finite() {
                *min += fraction * half;
                *max -= fraction * half;
            }
        };
        let constants = &self.constant_inputs;
        let finite = |j: usize| self.input_values.get(j).is_some_and(|values| !values.is_empty());
        let decided = ocp.input_bounds.iter_mut().enumerate().filter(|(j, _)| !constants.contains(j) && !finite(*j));
        decided.for_each(|(_, b)| shrink(&mut b.0, &mut b.1));
        ocp.state_bounds.iter_mut().for_each(|b| shrink(&mut b.min, &mut b.max));
        ocp
    }

    /// Whether the problem can be handed to a solver.
    ///
    /// `states` and `inputs` are those of the dynamics.
    ///
    /// # Errors
    /// Names the first thing that is wrong.
    pub fn check(&self, states: usize, inputs: usize) -> Result<(), MpcError> {
        let states = states + self.previous_inputs.len();
        if let Some(p) = self.previous_inputs.iter().find(|p| p.input >= inputs) {
            return Err(MpcError::Length { what: "the list of inputs", found: inputs, expected: p.input + 1 });
        }
        check_length("the list of state bounds", self.state_bounds.len(), states)?;
        check_length("the list of input bounds", self.input_bounds.len(), inputs)?;
        check_length("the list of state scales", self.state_scale.len(), states)?;
        check_length("the list of state sizes", self.sizes().len(), states)?;
        check_length("the list of state trusts", self.state_trust.len(), states)?;
        check_length("the list of input trusts", self.input_trust.len(), inputs)?;
        positive("the number of steps", self.steps as f64)?;
        positive("the interval dt", self.dt)?;
        self.check_lengths()?;
        positive("the number of substeps", self.substeps.least() as f64)?;
        self.integrator.check()?;
        if let Some(&value) = self.parameters.iter().flatten().find(|v| !v.is_finite()) {
            return Err(MpcError::Value { what: "a parameter".into(), value, remedy: "give a finite number" });
        }
        for s in self.state_scale.iter().chain(&self.state_size) {
            positive("a scale", *s)?;
        }
        for s in self.state_trust.iter().chain(&self.input_trust) {
            check_value(*s > 0.0, "a trust", *s, "give a positive number")?;
        }
        for (index, b) in self.state_bounds.iter().enumerate() {
            ordered("state", index, b.min, b.max)?;
            if let Softness::Soft { linear, quadratic } = b.softness {
                weight("a soft bound's linear weight", linear)?;
                weight("a soft bound's quadratic weight", quadratic)?;
            }
        }
        for (index, b) in self.input_bounds.iter().enumerate() {
            ordered("input", index, b.0, b.1)?;
        }
        for t in &self.targets {
            if t.state >= states {
                return Err(MpcError::NoSuchState { index: t.state, states });
            }
            check_value(t.value.is_finite(), "a target", t.value, "give a finite number")?;
            weight("a target's linear weight", t.linear)?;
            weight("a target's quadratic weight", t.quadratic)?;
        }
        if let Some(c) = &self.stage {
            c.check("the stage cost's list of variables", states + inputs)?;
        }
        if let Some(c) = &self.terminal {
            c.check("the terminal cost's list of variables", states)?;
        }
        self.check_constraints(states, inputs)?;
        let costs = self.stage.iter().chain(&self.terminal).map(CostFunction::references).max().unwrap_or(0);
        let references = costs.max(self.constraint_references());
        for row in &self.references {
            check_length("a row of references", row.len(), references)?;
        }
        if references > 0 && self.references.is_empty() {
            return Err(MpcError::Length { what: "the list of references", found: 0, expected: 1 });
        }
        Ok(())
    }

    /// Gives references and parameters the values that they have in the time of a trajectory.
    pub(crate) fn follow_time(&mut self, trajectory: &PlannedTrajectory) {
        let scaled = self.scaled_rows.as_mut().filter(|_| trajectory.steps() > 0);
        if let Some(rows) = scaled.and_then(|scaled| scaled.along(trajectory)) {
            (self.parameters, self.references) = (rows.parameters, rows.references);
        }
    }

    /// The references at grid point k.
    pub(crate) fn reference(&self, k: usize) -> &[f64] {
        row(&self.references, k.saturating_sub(self.first_row))
    }

    /// The live parameters of the dynamics at grid point k; none where the dynamics keep theirs.
    pub(crate) fn parameter_row(&self, k: usize) -> Option<&[f64]> {
        let last = self.parameters.len().checked_sub(1)?;
        Some(&self.parameters[k.saturating_sub(self.first_row).min(last)])
    }

    /// The stage cost l(x, u) at grid point k, without dt.
    pub(crate) fn stage_cost(&mut self, k: usize, t: f64, x: &[f64], u: &[f64]) -> f64 {
        let r = row(&self.references, k.saturating_sub(self.first_row));
        self.stage.as_mut().map_or(0.0, |c| c.value(x, u, t, &r[..c.references()]))
    }

    /// Stage and terminal costs of a trajectory that starts at grid point `k0` of the run, without penalties.
    pub(crate) fn cost(&mut self, k0: usize, trajectory: &PlannedTrajectory) -> f64 {
        self.costs(k0, trajectory).total()
    }

    /// Rounds the norms of the costs by this share of their sizes; false where there are none.
    pub(crate) fn round_norms(&mut self, share: f64) -> bool {
        if !self.has_norms() {
            return false;
        }
        let (mut x, u) = (self.sizes().to_vec(), self.input_trust.clone());
        x.resize(self.states(), 1.0);
        let row = row(&self.references, 0);
        for (cost, u) in [(&mut self.stage, &u[..]), (&mut self.terminal, &[])] {
            let Some(cost) = cost else { continue };
            let sizes: Vec<f64> = x.iter().chain(u).copied().collect();
            cost.measure_norms(CostPoint { x: &x, u, t: 0.0, r: &row[..cost.references()] }, &sizes);
            cost.round_norms(share);
        }
        true
    }

    /// Whether the costs have norms.
    pub(crate) fn has_norms(&self) -> bool {
        self.stage.iter().chain(&self.terminal).any(CostFunction::has_norms)
    }

    /// The parts of [`Ocp::cost`].
    pub(crate) fn costs(&mut self, k0: usize, trajectory: &PlannedTrajectory) -> HorizonCost {
        self.follow_time(trajectory);
        let steps = trajectory.steps();
        let mut stage = 0.0;
        for k in 0..steps {
            let (sample, t) = (self.sample(k0, k), self.time(k0, k));
            stage += self.length(k) * self.stage_cost(sample, t, trajectory.x(k), trajectory.u(k));
        }
        HorizonCost {
            stage,
            terminal: self.terminal_cost(self.sample(k0, steps), self.time(k0, steps), trajectory.x(steps)),
        }
    }

    /// The terminal cost of the state x at grid point k of the run.
    pub(crate) fn terminal_cost(&mut self, k: usize, t: f64, x: &[f64]) -> f64 {
        let r = row(&self.references, k.saturating_sub(self.first_row));
        self.terminal.as_mut().map_or(0.0, |c| c.value(x, &[], t, &r[..c.references()]))
    }

    /// Cost of violated bounds and constraints (hard ones at `hard` per unit of scale) and missed targets of a trajectory that
    /// starts at grid point `k0` of the run.
    pub(crate) fn penalty(&mut self, k0: usize, trajectory: &PlannedTrajectory, hard: f64) -> f64 {
        self.follow_time(trajectory);
        let mut sum = self.constraint_penalty(k0, trajectory, hard);
        for k in 1..=trajectory.steps() {
            for i in 0..self.state_bounds.len() {
                let b = self.state_bounds_at(k, i);
                let allowed = if b.softness == Softness::Hard { HARD_TOLERANCE * self.state_scale[i] } else { 0.0 };
                let v = b.violation(trajectory.x(k)[i]) - allowed;
                if v > 0.0 {
                    let (linear, quadratic) = self.weights(i, k, hard);
                    sum += linear * v + quadratic * v * v;
                }
            }
        }
        for t in &self.targets {
            let e = trajectory.x(trajectory.steps())[t.state] - t.value;
            sum += t.linear * e.abs() + t.quadratic * e * e;
        }
        sum
    }

    /// Weights of violation and its square of bound i at grid point k, the length of an interval included.
    pub(crate) fn weights(&self, i: usize, k: usize, hard: f64) -> (f64, f64) {
        self.state_bounds[i].softness.weights(self.share(k), hard / self.state_scale[i])
    }

    /// Largest violation of a hard bound or constraint, in units of its scale.
    pub(crate) fn hard_violation(&mut self, k0: usize, trajectory: &PlannedTrajectory) -> f64 {
        self.follow_time(trajectory);
        let mut worst = self.hard_constraint_violation(k0, trajectory);
        for k in 1..=trajectory.steps() {
            for i in 0..self.state_bounds.len() {
                let b = self.state_bounds_at(k, i);
                if b.softness == Softness::Hard {
                    worst = worst.max(b.violation(trajectory.x(k)[i]) / self.state_scale[i]);
                }
            }
        }
        worst
    }
}

/// Functions of states and inputs that programs linearize: path constraints, then the absolute values of the stage cost, then
/// those of the terminal cost, numbered in this order.
impl Ocp {
    /// Their numbers, bounds and grid points, and whether what a violation costs is multiplied by dt.
    pub(crate) fn row_functions(&self, steps: usize) -> impl Iterator<Item = (&PathConstraint, Range<usize>, bool)> {
        let path = self.path_constraints.iter().map(move |c| (c, c.grid_points(steps), true));
        let stage = self.stage.iter().flat_map(CostFunction::absolute);
        // The stage cost ends before the last state, and nothing changes the first one.
        let stage = stage.map(move |c| (c, c.grid_points(steps).start..steps, true));
        let terminal = self.terminal.iter().flat_map(CostFunction::absolute).map(move |c| (c, steps..steps + 1, false));
        path.chain(stage).chain(terminal)
    }

    /// Visits values and Jacobian of some of them at one grid point.
    pub(crate) fn row_function_at(
        &mut self,
        number: usize,
        (k, t): (usize, f64),
        (x, u): (&[f64], &[f64]),
        visit: impl FnOnce(&Bounds, f64, &[f64]),
    ) {
        let r = row(&self.references, k);
        let mut absolute = [&mut self.stage, &mut self.terminal];
        let [stage, terminal] = absolute.each_mut().map(|c| c.as_mut().map_or(&mut [][..], CostFunction::absolute_mut));
        let mut all = self.path_constraints.iter_mut().chain(stage).chain(terminal);
        if let Some(c) = all.nth(number) {
            let (g, jacobian) = c.function.values_and_jacobian(x, u, t, r);
            visit(&c.bounds, g[0], jacobian);
        }
    }
}

impl Ocp {
    /// Adds `weight` times the second derivatives of one of them at one grid point.
    pub(crate) fn add_row_curvature(
        &mut self,
        number: usize,
        (k, t): (usize, f64),
        (x, u): (&[f64], &[f64]),
        weight: f64,
        hessian: &mut [f64],
    ) {
        let r = row(&self.references, k);
        let mut absolute = [&mut self.stage, &mut self.terminal];
        let [stage, terminal] = absolute.each_mut().map(|c| c.as_mut().map_or(&mut [][..], CostFunction::absolute_mut));
        if let Some(c) = self.path_constraints.iter_mut().chain(stage).chain(terminal).nth(number) {
            c.function.add_second_derivatives(CostPoint { x, u, t, r }, weight, hessian);
        }
    }
}

/// Row k of a list; beyond the end the last one holds.
fn row(rows: &[Vec<f64>], k: usize) -> &[f64] {
    rows.get(k.min(rows.len().saturating_sub(1))).map_or(&[], Vec::as_slice)
}
