//! Compensation of a delay between measurement and input.

use crate::controller::{Controller, Step, forward_to};
use crate::dynamics::Dynamics;
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;
use crate::trajectory::PlannedTrajectory;
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
    /// Input decided last.
    last: Vec<f64>,
    /// One interval, for the choice of its substeps.
    held: PlannedTrajectory,
}

impl<C: Controller> DelayCompensated<C> {
    /// Wraps a controller. `dynamics` is the model to predict with (with the same live parameters as the
    /// controller's, where these are set), `first` the input that is applied until the first
    /// decision takes effect.
    ///
    /// # Errors
    /// If the model contradicts the controller's problem or a length is wrong.
    pub fn new(mut controller: C, dynamics: Box<dyn Dynamics>, delay: usize, first: &[f64]) -> Result<Self, MpcError> {
        let model = Transcription::new(dynamics, model_alone(controller.ocp()))?;
        check_length("the delayed input", first.len(), model.ocp.inputs())?;
        controller.set_start(delay);
        let x = vec![0.0; model.ocp.states()];
        let held = PlannedTrajectory::constant(1, &x, first);
        let pending = vec![first.to_vec(); delay].into();
        Ok(Self { controller, model, pending, k: 0, x, last: first.to_vec(), held })
    }

    /// Lets the input decided last wait for its turn.
    fn rotate(&mut self) {
        if let Some(mut u) = self.pending.pop_front() {
            u.copy_from_slice(&self.last);
            self.pending.push_back(u);
        }
        self.k += 1;
    }

    /// The controller inside.
    pub fn controller(&self) -> &C {
        &self.controller
    }
}

/// What a prediction needs of a problem: its grid and its parameters.
fn model_alone(ocp: &Ocp) -> Ocp {
    let mut alone = Ocp::new(ocp.model_states(), ocp.inputs(), ocp.steps, ocp.dt);
    (alone.integrator, alone.substeps) = (ocp.integrator, ocp.substeps);
    alone.parameters.clone_from(&ocp.parameters);
    alone.first_row = ocp.first_row;
    alone
}

impl<C: Controller> Controller for DelayCompensated<C> {
    forward_to!(self => self.controller; prepare, estimate, plan, ocp, limit_next_step, relaxed_plan, figures);

    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        check_length("the measured state", x.len(), self.x.len())?;
        self.x.copy_from_slice(x);
        if x.iter().all(|v| v.is_finite()) {
            for (i, u) in self.pending.iter().enumerate() {
                self.model.k0 = self.k + i;
                self.held.set(&self.x, u);
                self.model.choose_substeps(&self.held);
                self.model.predict(&mut self.x, u);
            }
        }
        let step = self.controller.feedback(&self.x)?;
        self.last.copy_from_slice(&step.u);
        Ok(step)
    }

    fn shift(&mut self) {
        self.rotate();
        self.controller.shift();
    }

    fn skip(&mut self) -> Result<(), MpcError> {
        self.rotate();
        self.controller.skip()
    }

    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError> {
        self.controller.change(change)?;
        self.model.ocp = model_alone(self.controller.ocp());
        Ok(())
    }

    fn set_start(&mut self, k0: usize) {
        self.k = k0;
        self.controller.set_start(k0 + self.pending.len());
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        self.model.set_parameters(parameters)?;
        self.controller.set_parameters(parameters)
    }
}
