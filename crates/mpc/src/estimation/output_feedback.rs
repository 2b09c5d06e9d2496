//! A controller that is given measured outputs in place of the state.

use super::estimate::{Estimate, Estimator};
use crate::controller::{Controller, Step, forward_to};
use crate::error::{MpcError, check_length};
use std::collections::VecDeque;

/// An estimator in front of a controller: a controller of measured outputs, which are NaN where nothing was measured.
///
/// The estimator is told the inputs that act, which are those decided `delay` samples before.
pub struct OutputFeedback<C, E> {
    controller: C,
    estimator: E,
    /// Whether the estimated parameters, and after them the estimated disturbances, become the live parameters of the
    /// controller's model.
    hand_over: bool,
    /// Decided inputs that do not act yet.
    pending: VecDeque<Vec<f64>>,
    /// The input since the last measurement; none before the first.
    applied: Option<Vec<f64>>,
    /// Input decided last.
    last: Vec<f64>,
    estimate: Option<Estimate>,
    parameters: Vec<f64>,
    /// A measurement of nothing, as long as the last one.
    nothing: Vec<f64>,
}

impl<C: Controller, E: Estimator> OutputFeedback<C, E> {
    /// Puts `estimator` in front of `controller`; with `hand_over`, its parameters and disturbances become the live parameters
    /// of the controller's model. `first` is the input of the first `delay` samples.
    ///
    /// # Errors
    /// If the length of `first` is not the number of inputs.
    pub fn new(controller: C, estimator: E, hand_over: bool, delay: usize, first: &[f64]) -> Result<Self, MpcError> {
        check_length("the delayed input", first.len(), controller.ocp().inputs())?;
        let last = first.to_vec();
        let pending = vec![last.clone(); delay].into();
        let (applied, estimate, parameters, nothing) = (None, None, Vec::new(), Vec::new());
        Ok(Self { controller, estimator, hand_over, pending, applied, last, estimate, parameters, nothing })
    }

    /// Lets the input decided last wait for its turn, and the next one act.
    fn rotate(&mut self) {
        let mut u = self.applied.take().unwrap_or_else(|| self.last.clone());
        u.copy_from_slice(&self.last);
        self.pending.push_back(u);
        self.applied = self.pending.pop_front();
    }

    /// The estimator.
    pub fn estimator(&self) -> &E {
        &self.estimator
    }
}

impl<C: Controller, E: Estimator> Controller for OutputFeedback<C, E> {
    forward_to!(self => self.controller;
        prepare, plan, ocp, change, set_start, limit_next_step, relaxed_plan, figures, set_parameters);

    fn feedback(&mut self, y: &[f64]) -> Result<&Step, MpcError> {
        let estimate = self.estimate.get_or_insert_with(Estimate::nothing);
        match &self.applied {
            None => self.estimator.correct_into(y, estimate)?,
            Some(u) => self.estimator.update_into(u, y, estimate)?,
        }
        self.nothing.resize(y.len(), f64::NAN);
        if self.hand_over {
            self.parameters.clear();
            self.parameters.extend(estimate.parameters.iter().chain(&estimate.disturbance));
            self.controller.set_parameters(&self.parameters)?;
        }
        let step = self.controller.feedback(&estimate.x)?;
        self.last.copy_from_slice(&step.u);
        Ok(step)
    }

    fn shift(&mut self) {
        self.rotate();
        self.controller.shift();
    }

    fn skip(&mut self) -> Result<(), MpcError> {
        if let Some(u) = &self.applied {
            let estimate = self.estimate.get_or_insert_with(Estimate::nothing);
            self.estimator.update_into(u, &self.nothing, estimate)?;
        }
        self.rotate();
        self.controller.skip()
    }

    fn estimate(&self) -> Option<&Estimate> {
        self.estimate.as_ref()
    }
}
