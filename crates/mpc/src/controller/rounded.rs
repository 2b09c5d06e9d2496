//! Inputs of finite sets behind a controller that plans with all values between their ends.

use super::interface::{Controller, PlanErrors, forward_to};
use super::step::{Step, StepStatus};
use super::sum_up_rounding::SumUpRounding;
use crate::error::MpcError;
use crate::trajectory::PlannedTrajectory;

/// An input of a finite set: its rounding up to the sample before, and including the present one.
struct FiniteInput {
    input: usize,
    before: SumUpRounding,
    now: SumUpRounding,
}

/// A controller whose inputs of finite sets are rounded, wherever they come from, with the error of rounding carried from sample to
/// sample.
pub(crate) struct Rounded {
    controller: Box<dyn Controller>,
    inputs: Vec<FiniteInput>,
    step: Step,
    /// The first plan, before rounding.
    relaxed: Option<PlannedTrajectory>,
    /// Largest |∫ (relaxed − rounded) dt| so far.
    largest: f64,
}

impl Rounded {
    /// Rounds the inputs that have [`values`](Ocp::input_values).
    pub(crate) fn new(controller: Box<dyn Controller>) -> Result<Self, MpcError> {
        let ocp = controller.ocp();
        let step = Step::undecided(ocp.inputs());
        let mut inputs = Vec::new();
        for (input, values) in ocp.input_values.iter().enumerate().filter(|(_, values)| !values.is_empty()) {
            let before = SumUpRounding::new(values)?;
            inputs.push(FiniteInput { input, now: before.clone(), before });
        }
        Ok(Self { controller, inputs, step, relaxed: None, largest: 0.0 })
    }
}

impl Controller for Rounded {
    forward_to!(self => self.controller;
        prepare, skip, estimate, plan, ocp, change, set_start, limit_next_step, set_parameters);

    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        self.step.copy_from(self.controller.feedback(x)?);
        if self.relaxed.is_none() && !matches!(self.step.status, StepStatus::Fallback(_) | StepStatus::PlayedOut) {
            self.relaxed = Some(self.controller.plan().clone());
        }
        let ocp = self.controller.ocp();
        for finite in &mut self.inputs {
            // A second answer for the same sample takes the place of the first one.
            finite.now.clone_from(&finite.before);
            let u = &mut self.step.u[finite.input];
            *u = finite.now.round_within(*u, ocp.dt, ocp.input_bounds[finite.input]);
        }
        Ok(&self.step)
    }
    fn shift(&mut self) {
        for finite in &mut self.inputs {
            finite.before.clone_from(&finite.now);
            self.largest = self.largest.max(finite.before.error().abs());
        }
        self.controller.shift();
    }
    fn figures(&self) -> PlanErrors {
        PlanErrors { rounding_error: Some(self.largest), ..self.controller.figures() }
    }
    fn relaxed_plan(&self) -> Option<&PlannedTrajectory> {
        self.relaxed.as_ref()
    }
}
