//! Control without offset, and without hunting where friction sticks.

use super::augmented::Augmented;
use super::problem::EstimationProblem;
use super::targets::{SteadyTarget, TargetCalculator, TargetStatus};
use crate::controller::{Controller, Step, StepLimits};
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;
use crate::rti::Rti;
use crate::trajectory::PlannedTrajectory;

/// Gives a controller the steady state and input that belong to a reference under the estimated disturbance, and keeps its
/// hands still where friction holds the state within a dead band of the reference.
///
/// The controller's cost has as its references the target's states, then its inputs. Parameters and disturbances arrive by
/// [`Controller::set_parameters`], which the loop calls when its estimates are handed over.
///
/// While friction sticks, a constant error does not show: an integrator winds up until the object breaks loose and overshoots,
/// over and over (hunting). Here the estimator freezes what sticking hides, so that nothing winds up, and within the dead band
/// the input that holds the state is held.
pub struct OffsetFree {
    controller: Rti,
    model: Augmented,
    targets: TargetCalculator,
    controlled: Vec<usize>,
    reference: Vec<f64>,
    /// Errors of the controlled outputs that are left alone while friction sticks.
    dead_band: Vec<f64>,
    parameters: Vec<f64>,
    /// Input decided last.
    last: Vec<f64>,
    step: Step,
    target: Option<SteadyTarget>,
}

impl OffsetFree {
    /// Wraps a controller whose model is the problem's [`controller_dynamics`](EstimationProblem::controller_dynamics);
    /// `controlled` are the indices of the measured outputs that follow `reference`.
    ///
    /// # Errors
    /// If a length is wrong or there is no output with such an index.
    pub fn new(
        controller: Rti,
        problem: &EstimationProblem,
        controlled: &[usize],
        reference: &[f64],
        dead_band: &[f64],
    ) -> Result<Self, MpcError> {
        check_length("the references", reference.len(), controlled.len())?;
        check_length("the dead band", dead_band.len(), controlled.len())?;
        let targets = TargetCalculator::new(problem, controlled, &controller.ocp().input_bounds)?;
        let model = Augmented::new(problem)?;
        let parameters = model.start.as_slice()[model.states..].to_vec();
        let last = vec![0.0; controller.ocp().inputs()];
        Ok(Self {
            controller,
            model,
            controlled: controlled.to_vec(),
            targets,
            reference: reference.to_vec(),
            dead_band: dead_band.to_vec(),
            parameters,
            step: Step::undecided(last.len()),
            last,
            target: None,
        })
    }

    /// Sets the reference of the controlled outputs.
    ///
    /// # Errors
    /// If the length is wrong.
    pub fn set_reference(&mut self, reference: &[f64]) -> Result<(), MpcError> {
        check_length("the references", reference.len(), self.reference.len())?;
        self.reference.copy_from_slice(reference);
        Ok(())
    }

    /// The target of the last step.
    pub fn target(&self) -> Option<&SteadyTarget> {
        self.target.as_ref()
    }

    /// Whether friction holds the state and the controlled outputs are near enough to what the target gives them.
    fn rests(&mut self, x: &[f64]) -> bool {
        let mut z = x.to_vec();
        z.extend(&self.parameters);
        let stuck = self.model.stuck(0.0, &z, &self.last);
        if stuck.is_empty() || stuck.contains(&false) {
            return false;
        }
        let (g, _) = self.model.outputs(0.0, &z);
        let errors = self.controlled.iter().zip(&self.reference).map(|(&i, r)| (g[i] - r).abs());
        errors.zip(&self.dead_band).all(|(e, band)| e <= *band)
    }
}

impl Controller for OffsetFree {
    fn prepare(&mut self) -> Result<(), MpcError> {
        Controller::prepare(&mut self.controller)
    }

    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        let target = self.targets.target(&self.reference, &self.parameters)?;
        if !matches!(target.status, TargetStatus::NotSteady { .. }) {
            let row = target.x.iter().chain(&target.u).copied().collect();
            self.controller.set_references(vec![row])?;
        }
        self.target = Some(target);
        let hold = x.iter().all(|v| v.is_finite()) && self.rests(x);
        self.step.copy_from(self.controller.feedback(x)?);
        if hold {
            self.step.u.clone_from(&self.last);
        }
        self.last.clone_from(&self.step.u);
        Ok(&self.step)
    }

    fn shift(&mut self) {
        Controller::shift(&mut self.controller);
    }

    fn plan(&self) -> &PlannedTrajectory {
        self.controller.trajectory()
    }

    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError> {
        Controller::change(&mut self.controller, change)
    }

    fn ocp(&self) -> &Ocp {
        self.controller.ocp()
    }

    fn set_start(&mut self, k0: usize) {
        Controller::set_start(&mut self.controller, k0);
    }

    fn limit_next_step(&mut self, limits: StepLimits) {
        Controller::limit_next_step(&mut self.controller, limits);
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        check_length("the parameters", parameters.len(), self.parameters.len())?;
        Controller::set_parameters(&mut self.controller, parameters)?;
        self.parameters.copy_from_slice(parameters);
        Ok(())
    }
}
