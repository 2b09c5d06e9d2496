//! The measured state in front of a controller of all branches of a scenario tree.

use super::interface::{Controller, PlanErrors, forward_to};
use super::step::{Step, StepStatus};
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;
use crate::trajectory::PlannedTrajectory;

/// A controller of one system around one of all branches of its scenario tree: every branch starts in the measured state, and the
/// first input, which the branches share, is applied.
pub(crate) struct Branches {
    controller: Box<dyn Controller>,
    /// The problem of one branch, and that of all of them.
    own: Ocp,
    all: Ocp,
    /// The branch whose plan is shown.
    shown: usize,
    count: usize,
    /// Grid point of the run at which the horizon starts.
    k: usize,
    x: Vec<f64>,
    step: Step,
    plan: PlannedTrajectory,
    /// Largest violation of a bound or constraint that a plan predicts in any branch.
    violation: Option<f64>,
}

impl Branches {
    pub(crate) fn new(controller: Box<dyn Controller>, own: Ocp, shown: usize) -> Self {
        let all = controller.ocp().clone();
        let branches = all.branching.as_ref().map_or(1, |b| b.branches);
        let x = vec![0.0; all.states()];
        let step = Step::undecided(own.inputs());
        let plan = shown_branch(controller.plan(), &own, branches, shown);
        Self { controller, own, all, shown, count: branches, k: 0, x, step, plan, violation: None }
    }

    fn show_plan(&mut self) {
        self.plan = shown_branch(self.controller.plan(), &self.own, self.count, self.shown);
    }
}

/// The trajectory of one of the branches; `own` is its problem.
pub(crate) fn shown_branch(all: &PlannedTrajectory, own: &Ocp, branches: usize, branch: usize) -> PlannedTrajectory {
    let (n, m, previous) = (own.model_states(), own.inputs(), own.previous_inputs.len());
    let mut shown = PlannedTrajectory::constant(all.steps(), &vec![0.0; n + previous], &vec![0.0; m]);
    for k in 0..=all.steps() {
        let remembered = branches * n + branch * previous;
        shown.x_mut(k)[..n].copy_from_slice(&all.x(k)[branch * n..(branch + 1) * n]);
        shown.x_mut(k)[n..].copy_from_slice(&all.x(k)[remembered..remembered + previous]);
    }
    for k in 0..all.steps() {
        shown.u_mut(k).copy_from_slice(&all.u(k)[branch * m..(branch + 1) * m]);
    }
    shown
}

impl Controller for Branches {
    forward_to!(self => self.controller; prepare, limit_next_step, set_parameters);

    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        check_length("the measured state", x.len(), self.own.states())?;
        let (states, previous) = x.split_at(self.own.model_states());
        self.x.clear();
        (0..self.count).for_each(|_| self.x.extend_from_slice(states));
        (0..self.count).for_each(|_| self.x.extend_from_slice(previous));
        let step = self.controller.feedback(&self.x)?;
        let m = self.own.inputs();
        self.step.u.copy_from_slice(&step.u[self.shown * m..(self.shown + 1) * m]);
        (self.step.status, self.step.source) = (step.status, step.source);
        (self.step.timings, self.step.effort, self.step.residual) = (step.timings, step.effort, step.residual);
        if !matches!(self.step.status, StepStatus::Fallback(_) | StepStatus::PlayedOut) {
            let violation = self.all.predicted_violation(self.k, self.controller.plan());
            let worst = self.violation.unwrap_or(0.0);
            // `f64::max` would drop a NaN.
            self.violation = Some(if worst.is_nan() || worst > violation { worst } else { violation });
        }
        self.show_plan();
        Ok(&self.step)
    }
    fn shift(&mut self) {
        self.k += 1;
        self.controller.shift();
        self.show_plan();
    }
    fn skip(&mut self) -> Result<(), MpcError> {
        self.k += 1;
        self.controller.skip()?;
        self.show_plan();
        Ok(())
    }
    fn plan(&self) -> &PlannedTrajectory {
        &self.plan
    }
    fn ocp(&self) -> &Ocp {
        &self.own
    }
    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError> {
        let mut changed = self.own.clone();
        change(&mut changed);
        let own = &self.own;
        self.controller.change(&mut |all| all.take_over_changes(own, &changed))?;
        self.all.take_over_changes(own, &changed);
        self.own = changed;
        self.show_plan();
        Ok(())
    }
    fn set_start(&mut self, k0: usize) {
        self.k = k0;
        self.controller.set_start(k0);
    }
    fn figures(&self) -> PlanErrors {
        PlanErrors { predicted_violation: self.violation, ..self.controller.figures() }
    }
}
