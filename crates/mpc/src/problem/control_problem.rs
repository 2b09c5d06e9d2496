//! A control problem as data.

use super::chance::ChanceReport;
use super::conditions::RunConditions;
use super::estimation::Estimation;
use super::found_values::FoundValues;
use super::method::{Method, MethodReason};
use super::notes::Note;
use super::schedule::{ReferenceUse, Schedule};
use crate::controller::FailurePolicy;
use crate::dynamics::SymbolicDynamics;
use crate::error::MpcError;
use crate::ocp::Ocp;
use crate::qp::QpSettings;
use bracketry_symbolic::{Named, StopFlag};
use bracketry_system::{AffineError, FileError, System};
use std::sync::Arc;

/// A problem file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ProblemError {
    /// The file, or a model it names, is wrong at a known place.
    #[error(transparent)]
    File(#[from] Box<FileError>),
    /// The model uses derivatives of its inputs and could not be made affine.
    #[error("the model uses derivatives of its inputs and cannot be made affine: {0}")]
    Affine(#[from] AffineError),
    /// The pieces do not fit together.
    #[error(transparent)]
    Mpc(#[from] MpcError),
}

impl From<FileError> for ProblemError {
    fn from(e: FileError) -> Self {
        Self::File(Box::new(e))
    }
}

/// A control problem as its file states it.
#[derive(Clone)]
pub struct ControlProblem {
    /// The controller's model. Where the file's uses derivatives of inputs, as `der(X, 2)`, it has been made affine: `X` and
    /// `Xd` are states and `Xdd` is the input.
    pub system: System,
    /// The model of the plant; the controller's where the file names no other.
    pub plant: System,
    /// Horizon, cost, constraints and targets.
    pub ocp: Ocp,
    /// How the loop is closed, with the settings of that method; [`Method::Automatic`] where the file names none.
    pub method: Method,
    /// Why it is this method; a choice at the start of a controller replaces it.
    pub method_reason: MethodReason,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
    /// Widths that replace `sign` in the controller's model, from wide to narrow; the loop uses the last. When empty, those of the
    /// method: [`ControlProblem::widths`].
    pub smoothing: Vec<f64>,
    /// What is applied when a sample has no solution.
    pub policy: FailurePolicy,
    /// Input of rest; when empty, the one closest to zero within the bounds.
    pub rest_input: Vec<f64>,
    /// Parameters of the controller's model that change over the run, as [`Ocp::parameters`] has them.
    pub live: Vec<String>,
    /// Those of them that are functions of time or changed from outside, and the references, with their values over the run.
    pub schedule: Schedule,
    /// What becomes of every reference.
    pub references: Vec<ReferenceUse>,
    /// What is to be said of the problem, however it runs.
    pub remarks: Vec<Note>,
    /// Inputs of the first guess, one row per interval.
    pub guess: Vec<Vec<f64>>,
    /// Initial state; zeros where the file has no `[run]`.
    pub x0: Vec<f64>,
    /// Whether the file has a `[run]`. Without one, there is nothing to run, and a live controller of measured states starts from the
    /// first measurement.
    pub has_run: bool,
    /// Inputs applied before the first sample; when empty, those at rest.
    pub u0: Vec<f64>,
    /// Number of samples of the run.
    pub samples: usize,
    /// Integration steps of a smooth plant per sample.
    pub plant_substeps: usize,
    /// Noise, delay and faults.
    pub conditions: RunConditions,
    /// What is measured, and the estimator; without it the states are measured.
    pub estimation: Option<Estimation>,
    /// What is left free; none once values were found for it, see [`ControlProblem::with_free_values`].
    pub(crate) free: Option<Arc<FreeValues>>,
    /// The margins of bounds that hold with a probability, where there is noise.
    pub chance: Option<ChanceReport>,
    /// The branches, where parameters are uncertain.
    pub(crate) scenarios: Option<Arc<ScenarioTree>>,
    /// The values found for what was free.
    pub found: Option<FoundValues>,
    /// The compiled model of a problem that has been started; whoever changes `system` or `live` starts anew.
    pub(crate) compiled: Option<Box<SymbolicDynamics>>,
    /// Once it is raised, planning and running end with [`MpcError::Stopped`](crate::MpcError::Stopped).
    pub stop: StopFlag,
}

impl ControlProblem {
    /// Widths that replace `sign` in the controller's model, from wide to narrow: those given, else those of the method.
    pub fn widths(&self) -> Vec<f64> {
        if self.smoothing.is_empty() { self.method.widths().to_vec() } else { self.smoothing.clone() }
    }

    /// The sampling period, s; infinite where the time of the model has no unit, so that nothing is late.
    pub fn period_seconds(&self) -> f64 {
        self.system.quantities.time_unit.seconds().map_or(f64::INFINITY, |seconds| seconds * self.ocp.dt)
    }

    /// Lets an estimator make states of what is measured. Parameters and disturbances that it estimates are given to the controller's
    /// model at every sample.
    ///
    /// # Errors
    /// If the estimation problem does not fit the model.
    pub fn set_estimation(&mut self, estimation: Estimation) -> Result<(), MpcError> {
        if estimation.hands_over() {
            self.live = estimation.problem.live_parameters();
            self.system = estimation.problem.controller_model()?;
        }
        self.estimation = Some(estimation);
        Ok(())
    }
}

/// The problem with the values found put into its file.
pub(crate) type WithFound = Box<dyn Fn(&FoundValues) -> Result<ControlProblem, ProblemError> + Send + Sync>;

/// A problem with something free: the one to be solved for it, in which it is the last inputs, and what becomes of it.
pub(crate) struct FreeValues {
    pub(super) extended: ControlProblem,
    pub(super) parameters: Vec<String>,
    /// Guess of the end time, s, where it is free.
    pub(super) end_time: Option<f64>,
    pub(super) with_found: WithFound,
}

impl FreeValues {
    pub(crate) fn new(
        extended: ControlProblem,
        parameters: &[String],
        end_time: Option<f64>,
        with_found: WithFound,
    ) -> Self {
        Self { extended, parameters: parameters.to_vec(), end_time, with_found }
    }
}

/// The problem of all branches: the product of as many copies of the model, with the weighted mean of their costs.
pub(crate) struct ScenarioTree {
    pub(crate) problem: ControlProblem,
    /// The problem of one branch, as the file has it.
    pub(crate) own: Ocp,
    /// The branch of the model's own values, whose plan is shown.
    pub(crate) nominal: usize,
    pub(crate) robust_horizon: usize,
    pub(crate) combinations: Vec<Named<f64>>,
}
