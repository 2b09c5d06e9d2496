//! A control problem as data.

use super::conditions::RunConditions;
use super::estimation::Estimation;
use super::method::Method;
use crate::controller::FailurePolicy;
use crate::error::MpcError;
use crate::ocp::Ocp;
use crate::qp::QpSettings;
use bracketry_symbolic::StopFlag;
use bracketry_system::{AffineError, FileError, System};

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
    /// How the loop is closed, with the settings of that method.
    pub method: Method,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
    /// Widths that replace `sign` in the controller's model, from wide to narrow; the loop uses the last.
    pub smoothing: Vec<f64>,
    /// What is applied when a sample has no solution.
    pub policy: FailurePolicy,
    /// Input of rest; when empty, the one closest to zero within the bounds.
    pub rest_input: Vec<f64>,
    /// Parameters of the controller's model that change over the run, as [`Ocp::parameters`] has them.
    pub live: Vec<String>,
    /// Inputs of the first guess, one row per interval.
    pub guess: Vec<Vec<f64>>,
    /// Initial state.
    pub x0: Vec<f64>,
    /// Number of samples of the run.
    pub samples: usize,
    /// Integration steps of a smooth plant per sample.
    pub plant_substeps: usize,
    /// Noise, delay and faults.
    pub conditions: RunConditions,
    /// What is measured, and the estimator; without it the states are measured.
    pub estimation: Option<Estimation>,
    /// Once it is raised, planning and running end with [`MpcError::Stopped`](crate::MpcError::Stopped).
    pub stop: StopFlag,
}
