//! The input applied last, in front of a controller whose problem counts it to the state.

use super::interface::{Controller, forward_to};
use super::step::{Step, StepStatus};
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;
use crate::trajectory::PlannedTrajectory;

/// A controller of the dynamics' state around one whose problem has [`previous inputs`](Ocp::previous_inputs): it appends to
/// every measured state the input decided last, wherever that came from. Inputs of a failure policy keep the limits of the rates.
pub(crate) struct WithPreviousInput {
    controller: Box<dyn Controller>,
    /// Input decided last.
    last: Vec<f64>,
    states: usize,
    /// The state with the previous inputs.
    x: Vec<f64>,
    step: Step,
    /// The plan of the controller without previous inputs.
    plan: PlannedTrajectory,
}

impl WithPreviousInput {
    /// `before` is the input applied before the first sample.
    pub(crate) fn new(controller: Box<dyn Controller>, before: &[f64]) -> Result<Self, MpcError> {
        let ocp = controller.ocp();
        check_length("the input before the first sample", before.len(), ocp.inputs())?;
        let (states, all) = (ocp.model_states(), ocp.states());
        let step = Step::undecided(ocp.inputs());
        let plan = controller.plan().first_states(states);
        Ok(Self { controller, last: before.to_vec(), states, x: vec![0.0; all], step, plan })
    }

    fn copy_plan(&mut self) {
        self.plan.copy_first_states(self.controller.plan());
    }
}

impl Controller for WithPreviousInput {
    forward_to!(self => self.controller;
        prepare, estimate, ocp, set_start, limit_next_step, relaxed_plan, figures, set_parameters);

    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        check_length("the measured state", x.len(), self.states)?;
        self.x.clear();
        self.x.extend_from_slice(x);
        if x.iter().all(|v| v.is_nan()) {
            // Nothing was measured, and the controller inside has to see that.
            self.x.resize(self.states + self.controller.ocp().previous_inputs.len(), f64::NAN);
        } else {
            self.controller.ocp().append_previous(&mut self.x, &self.last);
        }
        self.step.copy_from(self.controller.feedback(&self.x)?);
        if matches!(self.step.status, StepStatus::Fallback(_) | StepStatus::PlayedOut) {
            let ocp = self.controller.ocp();
            for p in &ocp.previous_inputs {
                let (last, (min, max)) = (self.last[p.input], ocp.input_bounds[p.input]);
                let u = &mut self.step.u[p.input];
                *u = u.clamp(last + ocp.dt * p.rate.0, last + ocp.dt * p.rate.1).clamp(min, max);
            }
        }
        self.last.copy_from_slice(&self.step.u);
        self.copy_plan();
        Ok(&self.step)
    }
    fn shift(&mut self) {
        self.controller.shift();
        self.copy_plan();
    }
    fn skip(&mut self) -> Result<(), MpcError> {
        self.controller.skip()?;
        self.copy_plan();
        Ok(())
    }
    fn plan(&self) -> &PlannedTrajectory {
        &self.plan
    }
    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError> {
        self.controller.change(change)?;
        self.copy_plan();
        Ok(())
    }
}
