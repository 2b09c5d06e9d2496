//! The optimal control problem as data.

use super::bounds::{Bounds, HARD_TOLERANCE, Softness, ordered, positive, weight};
use super::constraint::{NormConstraint, PathConstraint, TerminalSet};
use super::cost::CostFunction;
use crate::error::{MpcError, check_length, check_value};
use crate::integrator::Integrator;
use crate::trajectory::Trajectory;

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
    /// Length of an interval, s.
    pub dt: f64,
    /// Method that advances the state over an interval.
    pub integrator: Integrator,
    /// Integration steps per interval.
    pub substeps: Substeps,
    /// Integrand of the cost.
    pub stage: Option<CostFunction>,
    /// Cost of the last state; a function of the states alone.
    pub terminal: Option<CostFunction>,
    /// Values of the references at grid point k, from the start of the run; beyond the end the last row holds.
    pub references: Vec<Vec<f64>>,
    /// Values of the live parameters of the dynamics at grid point k, from the start of the run; beyond the end the last row
    /// holds. When empty, the dynamics keep their values.
    pub parameters: Vec<Vec<f64>>,
    /// Bounds of every input, always hard.
    pub input_bounds: Vec<(f64, f64)>,
    /// Bounds of every state at the grid points 1 … N.
    pub state_bounds: Vec<Bounds>,
    /// Targets at the end.
    pub targets: Vec<TerminalTarget>,
    /// Functions of states and inputs that are kept within bounds.
    pub path_constraints: Vec<PathConstraint>,
    /// Vectors whose length is limited.
    pub norm_constraints: Vec<NormConstraint>,
    /// Numbers of intervals over which the inputs are held, in order; their sum is N. Empty: the inputs of every interval
    /// are free. A shrinking horizon loses intervals from the front of the first block.
    pub move_blocks: Vec<usize>,
    /// A set in which the last state shall lie.
    pub terminal_set: Option<TerminalSet>,
    /// Typical size of each state: defects are measured in it.
    pub state_scale: Vec<f64>,
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
            integrator: Integrator::Rk4,
            substeps: Substeps::AtLeast(1),
            stage: None,
            terminal: None,
            references: Vec::new(),
            parameters: Vec::new(),
            input_bounds: vec![(f64::NEG_INFINITY, f64::INFINITY); inputs],
            state_bounds: vec![Bounds::FREE; states],
            targets: Vec::new(),
            path_constraints: Vec::new(),
            norm_constraints: Vec::new(),
            move_blocks: Vec::new(),
            terminal_set: None,
            state_scale: vec![1.0; states],
            state_trust: vec![f64::INFINITY; states],
            input_trust: vec![1.0; inputs],
        }
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.state_bounds.len()
    }

    /// Number of inputs.
    pub fn inputs(&self) -> usize {
        self.input_bounds.len()
    }

    /// Largest violation of a bound by states or inputs, each in its own unit; 0 when all are kept, NaN when a bounded
    /// value is no number.
    pub fn largest_violation(&self, x: &[Vec<f64>], u: &[Vec<f64>]) -> f64 {
        // `f64::max` would drop a NaN.
        let states = x
            .iter()
            .flat_map(|x| x.iter().zip(&self.state_bounds))
            .map(|(v, b)| if v.is_nan() && !b.is_free() { f64::NAN } else { b.violation(*v) });
        let inputs = u.iter().flat_map(|u| u.iter().zip(&self.input_bounds)).map(|(v, b)| (b.0 - v).max(v - b.1));
        states
            .chain(inputs)
            .fold(0.0, |worst: f64, v| if worst.is_nan() || v.is_nan() { f64::NAN } else { worst.max(v) })
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
        ocp.input_bounds.iter_mut().for_each(|b| shrink(&mut b.0, &mut b.1));
        ocp.state_bounds.iter_mut().for_each(|b| shrink(&mut b.min, &mut b.max));
        ocp
    }

    /// Whether the problem can be handed to a solver.
    ///
    /// # Errors
    /// Names the first thing that is wrong.
    pub fn check(&self, states: usize, inputs: usize) -> Result<(), MpcError> {
        check_length("the list of state bounds", self.state_bounds.len(), states)?;
        check_length("the list of input bounds", self.input_bounds.len(), inputs)?;
        check_length("the list of state scales", self.state_scale.len(), states)?;
        check_length("the list of state trusts", self.state_trust.len(), states)?;
        check_length("the list of input trusts", self.input_trust.len(), inputs)?;
        positive("the number of steps", self.steps as f64)?;
        positive("the interval dt", self.dt)?;
        positive("the number of substeps", self.substeps.least() as f64)?;
        self.integrator.check()?;
        if let Some(&value) = self.parameters.iter().flatten().find(|v| !v.is_finite()) {
            return Err(MpcError::Value { what: "a parameter".into(), value, remedy: "give a finite number" });
        }
        for s in &self.state_scale {
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

    /// The references at grid point k.
    pub(crate) fn reference(&self, k: usize) -> &[f64] {
        row(&self.references, k)
    }

    /// The stage cost l(x, u) at grid point k, without dt.
    pub(crate) fn stage_cost(&mut self, k: usize, t: f64, x: &[f64], u: &[f64]) -> f64 {
        let r = row(&self.references, k);
        self.stage.as_mut().map_or(0.0, |c| c.value(x, u, t, &r[..c.references()]))
    }

    /// Stage and terminal costs of a trajectory that starts at grid point `k0` of the run, without penalties.
    pub(crate) fn cost(&mut self, k0: usize, trajectory: &Trajectory) -> f64 {
        let dt = self.dt;
        let steps = trajectory.steps();
        let mut sum = 0.0;
        for k in 0..steps {
            sum += dt * self.stage_cost(k0 + k, (k0 + k) as f64 * dt, trajectory.x(k), trajectory.u(k));
        }
        let end = k0 + steps;
        let r = row(&self.references, end);
        sum + self
            .terminal
            .as_mut()
            .map_or(0.0, |c| c.value(trajectory.x(steps), &[], end as f64 * dt, &r[..c.references()]))
    }

    /// Cost of violated bounds and constraints (hard ones at `hard` per unit of scale) and missed targets of a trajectory that
    /// starts at grid point `k0` of the run.
    pub(crate) fn penalty(&mut self, k0: usize, trajectory: &Trajectory, hard: f64) -> f64 {
        let mut sum = self.constraint_penalty(k0, trajectory, hard);
        for k in 1..=trajectory.steps() {
            for (i, b) in self.state_bounds.iter().enumerate() {
                let allowed = if b.softness == Softness::Hard { HARD_TOLERANCE * self.state_scale[i] } else { 0.0 };
                let v = b.violation(trajectory.x(k)[i]) - allowed;
                if v > 0.0 {
                    let (linear, quadratic) = self.weights(i, hard);
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

    /// Weights of violation and its square of bound i, dt included.
    pub(crate) fn weights(&self, i: usize, hard: f64) -> (f64, f64) {
        self.state_bounds[i].softness.weights(self.dt, hard / self.state_scale[i])
    }

    /// Largest violation of a hard bound or constraint, in units of its scale.
    pub(crate) fn hard_violation(&mut self, k0: usize, trajectory: &Trajectory) -> f64 {
        let mut worst = self.hard_constraint_violation(k0, trajectory);
        for k in 1..=trajectory.steps() {
            for (i, b) in self.state_bounds.iter().enumerate() {
                if b.softness == Softness::Hard {
                    worst = worst.max(b.violation(trajectory.x(k)[i]) / self.state_scale[i]);
                }
            }
        }
        worst
    }
}

/// Row k of a list; beyond the end the last one holds.
fn row(rows: &[Vec<f64>], k: usize) -> &[f64] {
    rows.get(k.min(rows.len().saturating_sub(1))).map_or(&[], Vec::as_slice)
}
