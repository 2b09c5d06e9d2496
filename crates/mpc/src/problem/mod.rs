//! Problem files: model, horizon, cost, constraints and run in one TOML file.

mod conditions;
mod constraints;
mod cost;
mod estimation;
mod horizon;
mod method;
mod reader;
mod report;
mod run;
mod scaling;
mod solve;

pub use conditions::RunConditions;
pub use estimation::{Estimation, EstimatorKind};
pub use method::{Convergence, Feedback, Method};
pub use report::{ControlReport, NamedValues, PlanReport};
pub use run::ControlRun;

use crate::error::MpcError;
use crate::ocp::Ocp;
use crate::policy::FailurePolicy;
use crate::qp::QpSettings;
use bracketry_symbolic::StopFlag;
use bracketry_system::{AffineError, Document, FileError, System};
use reader::{KEYS, Reader};
use std::path::Path;

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

impl ControlProblem {
    /// Reads a problem file; the model is looked for beside it.
    ///
    /// # Errors
    /// [`ProblemError`] with the place in the file and the remedy.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, ProblemError> {
        let path = path.as_ref();
        let doc = Document::read(path)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::from_document(&doc, |name| System::read(folder.join(name)).map_err(Box::new))
    }

    /// Reads a problem from text; `models` finds the models that it names.
    ///
    /// # Errors
    /// As [`ControlProblem::read`].
    pub fn parse(
        file: &str,
        text: &str,
        models: impl FnMut(&str) -> Result<System, Box<FileError>>,
    ) -> Result<Self, ProblemError> {
        Self::from_document(&Document::new(file, text), models)
    }

    fn from_document(
        doc: &Document,
        mut models: impl FnMut(&str) -> Result<System, Box<FileError>>,
    ) -> Result<Self, ProblemError> {
        let table = doc.table()?;
        doc.only_keys(&table, &KEYS, "a problem file")?;
        let Some(model) = doc.string(&table, "model")? else {
            return Err(doc.missing("no model is named", "add `model = \"model.toml\"` at the top").into());
        };
        let mut system = with_own_inputs(models(&model)?)?;
        system.leaves_time_free(&doc)?;
        let original = system.clone();
        Reader { doc, system: &original }.fixed_parameters(&table, &mut system)?;
        let mut plant = match doc.string(&table, "plant")? {
            Some(name) => with_own_inputs(models(&name)?)?,
            None => system.clone(),
        };
        if plant.state_names() != system.state_names() || plant.input_names() != system.input_names() {
            let names =
                |s: &System| format!("states {}, inputs {}", s.state_names().join(" "), s.input_names().join(" "));
            let message =
                format!("model and plant differ: {} in the model, {} in the plant", names(&system), names(&plant));
            return Err(doc.missing(message, "give both the same states and inputs in the same order").into());
        }
        let reader = Reader { doc, system: &system };
        if let Some(run) = doc.sub_table(&table, "run")? {
            reader.plant_parameters(run, &mut plant)?;
        }
        let mut problem = reader.problem(&table, plant)?;
        if let Some(e) = problem.estimation.as_ref().filter(|e| e.hands_over()) {
            if !problem.live.is_empty() {
                let message =
                    "parameters that change over time and an estimator that hands parameters over do not go together";
                return Err(doc.missing(message, "make one of them constant").into());
            }
            (problem.system, problem.live) = e.disturbed(&system);
        }
        let checked = problem.ocp.check(problem.system.states.len(), problem.system.inputs.len());
        checked.map_err(|e| doc.missing(e.to_string(), "change the value that it names"))?;
        Ok(problem)
    }
}

/// A system without derivatives of inputs: integrators in front of those that have them.
fn with_own_inputs(system: System) -> Result<System, ProblemError> {
    if system.input_derivatives.is_empty() { Ok(system) } else { Ok(system.affinize()?.system) }
}
