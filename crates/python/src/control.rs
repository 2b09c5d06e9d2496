//! Closed loops of control problems.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bracketry::mpc::{ControlError, ControlProblem, MpcError};
use bracketry::report::control as report;
use bracketry::system::{Accepted, System};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::watched;
use crate::model::{Model, titles};
use crate::tables::{Answer, matrix};

/// Runs the closed loop of a problem file, or of its text with the models that it names.
#[pyfunction]
#[pyo3(signature = (*, path, text, folder, models, seed))]
pub(crate) fn control<'py>(
    py: Python<'py>,
    path: Option<PathBuf>,
    text: Option<String>,
    folder: PathBuf,
    models: HashMap<String, Bound<'py, Model>>,
    seed: Option<u64>,
) -> PyResult<Bound<'py, PyDict>> {
    let models = models_of(&models);
    let (answer, controlled, problem) = watched(py, move |stop| {
        let mut problem = read(path.as_deref(), text.as_deref(), &folder, &models)?;
        if let Some(seed) = seed {
            problem.conditions.seed = seed;
        }
        problem.stop = stop.clone();
        let problem = problem.with_free_values()?.into_owned();
        let controlled = Arc::new(bracketry::control(&problem).map_err(|e| match e {
            ControlError::Mpc(MpcError::Plant { .. }) => Failure::new(report::error(&problem, &e)),
            other => other.into(),
        })?);
        let problem = Arc::new(problem);
        let drawn = (Arc::clone(&controlled), Arc::clone(&problem));
        let figures = Figures::default().with("closed_loop", move || report::figure(&drawn.1, &drawn.0));
        let outcome = &controlled.run.report;
        let (json, text) = (serde_json::to_string(outcome)?, report::text(outcome));
        Ok((Answer { json, text, figures }, controlled, problem))
    })?;
    let run = &controlled.run.closed_loop;
    let (states, inputs) = (problem.plant.state_names(), problem.plant.input_names());
    let dict = answer.into_dict(py)?;
    dict.set_item("t", run.t.clone().into_pyarray(py))?;
    dict.set_item("states", matrix(py, &run.x, states.len())?)?;
    dict.set_item("inputs", matrix(py, &run.u, inputs.len())?)?;
    dict.set_item("measured", matrix(py, &run.y, run.y.first().map_or(0, Vec::len))?)?;
    dict.set_item("estimates", matrix(py, &run.estimates, run.estimates.first().map_or(0, Vec::len))?)?;
    dict.set_item("state_names", states)?;
    dict.set_item("input_names", inputs)?;
    dict.set_item("titles", titles(&problem.plant))?;
    Ok(dict)
}

/// Systems by the names under which a problem speaks of them.
pub(crate) fn models_of(models: &HashMap<String, Bound<'_, Model>>) -> HashMap<String, System> {
    models.iter().map(|(name, m)| (name.clone(), m.get().system.clone())).collect()
}

pub(crate) fn read(
    path: Option<&Path>,
    text: Option<&str>,
    folder: &Path,
    models: &HashMap<String, System>,
) -> Result<ControlProblem, Failure> {
    match (path, text) {
        (Some(path), _) => Ok(ControlProblem::read(path)?),
        (None, Some(text)) => {
            let model = |name: &str| {
                if let Some(system) = models.get(name) {
                    return Ok(system.clone());
                }
                let accepted = Accepted { discrete: true, algebraic: true };
                System::read_accepting(folder.join(name), accepted).map_err(Box::new)
            };
            Ok(ControlProblem::parse("problem", text, model)?)
        }
        (None, None) => Err(Failure::new("give a problem")),
    }
}
