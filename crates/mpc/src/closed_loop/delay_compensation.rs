//! Compensation of a delay between measurement and input.

use crate::controller::{Controller, Step, StepLimits};
use crate::dynamics::Dynamics;
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;
use crate::trajectory::Trajectory;
use crate::transcription::Transcription;
use std::collections::VecDeque;

/// A controller whose inputs are applied `delay` samples after the measurement they answer: it hands the state that the
/// model predicts over the commanded inputs that have not acted yet.
///
/// The horizon of the controller inside starts `delay` samples after the measurement.
pub struct DelayCompensated<C> {
    controller: C,
    model: Transcription,
    pending: VecDeque<Vec<f64>>,
    /// Grid point of the run at the measurement.
    k: usize,
    x: Vec<f64>,
}

impl<C: Controller> DelayCompensated<C> {
    /// Wraps a controller. `dynamics` is the model to predict with (with the same live parameters as the
    /// controller's, where these are set), `first` the input that is applied until the first
    /// decision takes effect.
    ///
    /// # Errors
    /// If the model contradicts the controller's problem or a length is wrong.
    pub fn new(mut controller: C, dynamics: Box<dyn Dynamics>, delay: usize, first: &[f64]) -> Result<Self, MpcError> {
        let model = Transcription::new(dynamics, controller.ocp().clone())?;
        check_length("the delayed input", first.len(), model.ocp.inputs())?;
        controller.set_start(delay);
        let x = vec![0.0; model.ocp.states()];
        Ok(Self { controller, model, pending: vec![first.to_vec(); delay].into(), k: 0, x })
    }

    /// The controller inside.
    pub fn controller(&self) -> &C {
        &self.controller
    }
}

impl<C: Controller> Controller for DelayCompensated<C> {
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError> {
        check_length("the measured state", x.len(), self.x.len())?;
        self.x.copy_from_slice(x);
        if x.iter().all(|v| v.is_finite()) {
            for (i, u) in self.pending.iter().enumerate() {
                self.model.k0 = self.k + i;
                self.model.choose_substeps(&Trajectory::constant(1, &self.x, u));
                self.model.predict(&mut self.x, u);
            }
        }
        let step = self.controller.step(&self.x)?;
        self.pending.push_back(step.u.clone());
        self.pending.pop_front();
        self.k += 1;
        Ok(step)
    }

    fn ocp(&self) -> &Ocp {
        self.controller.ocp()
    }

    fn set_start(&mut self, k0: usize) {
        self.k = k0;
        self.controller.set_start(k0 + self.pending.len());
    }

    fn limit_next_step(&mut self, limits: StepLimits) {
        self.controller.limit_next_step(limits);
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        self.model.set_parameters(parameters)?;
        self.controller.set_parameters(parameters)
    }
}
