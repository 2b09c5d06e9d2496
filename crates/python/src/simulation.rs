//! Simulations with exact stick–slip friction.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use bracketry::report::simulation;
use bracketry::sim::{InputError, SampledScenario, Samples, Scenario, ScenarioRun, SimulationSettings};
use bracketry::system::{Columns, FileError, System};
use numpy::{IntoPyArray, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::watched;
use crate::model::Model;
use crate::tables::{Answer, hold, matrix};

/// Times and values of a sampled input.
type Sampled<'py> = (PyReadonlyArray1<'py, f64>, PyReadonlyArray1<'py, f64>);

/// What drives a simulation, as it was given.
struct Given {
    /// Text of a scenario file. Beside a table of inputs it gives initial state and parameters.
    text: Option<String>,
    file: Option<PathBuf>,
    table: Option<PathBuf>,
    /// Sampled inputs, or their derivatives, by name.
    samples: Vec<(String, Samples)>,
    hold: bracketry::sim::Hold,
    start: f64,
    /// Beside a table of inputs: duration and distance of rows in place of the table's.
    duration: Option<f64>,
    sample: Option<f64>,
    ignored: Vec<String>,
}

impl Given {
    fn scenario(self, system: &System) -> Result<SampledScenario, Failure> {
        if let Some(table) = self.table {
            let mut given = Scenario::from_csv(&table, system, self.hold)?;
            if let Some(text) = &self.text {
                let own = parsed(text, system)?;
                (given.scenario.x0, given.scenario.parameters) = (own.x0, own.parameters);
            }
            given.scenario.end = self.duration.map_or(given.scenario.end, |duration| given.scenario.start + duration);
            given.scenario.sample = self.sample.unwrap_or(given.scenario.sample);
            return Ok(given);
        }
        let mut scenario = match (&self.file, &self.text) {
            (Some(file), _) => Scenario::read(file, system)?,
            (None, Some(text)) => parsed(text, system)?,
            (None, None) => return Err(Failure::new("give a duration, a scenario file, or a table of inputs")),
        };
        for (name, samples) in self.samples {
            scenario.inputs = match Columns::derivative_name(&name) {
                Some((input, order)) => scenario.inputs.derivative(input, order, samples),
                None => scenario.inputs.samples(&name, samples),
            };
        }
        scenario.start += self.start;
        scenario.end += self.start;
        let held_at_zero = scenario.inputs_at_zero(system);
        Ok(SampledScenario { scenario, ignored: self.ignored, held_at_zero })
    }
}

/// A scenario from a text that the Python function wrote: places in it are of no use to anyone.
fn parsed(text: &str, system: &System) -> Result<Scenario, Failure> {
    let plain = |e: FileError| Failure::new(format!("{}\n   = {}", e.message, e.remedy));
    Scenario::parse("simulate", text, system).map_err(plain)
}

/// Integrates a model.
#[pyfunction]
#[pyo3(signature = (model, *, text, file, table, samples, hold_inputs, start, duration, sample, rtol, atol, ignored))]
#[allow(clippy::too_many_arguments, reason = "keywords, all of them given by the Python function")]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    text: Option<String>,
    file: Option<PathBuf>,
    table: Option<PathBuf>,
    samples: HashMap<String, Sampled<'py>>,
    hold_inputs: &str,
    start: f64,
    duration: Option<f64>,
    sample: Option<f64>,
    rtol: Option<f64>,
    atol: Option<f64>,
    ignored: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let hold = hold(hold_inputs)?;
    let sampled = |(name, (t, v)): (String, Sampled<'py>)| -> Result<(String, Samples), Failure> {
        let samples = Samples::new(t.as_array().to_vec(), v.as_array().to_vec(), hold);
        let about = |e: InputError| match e {
            InputError::BadSamples { row, problem } => {
                Failure::new(format!("samples of the input `{name}`, entry {row}: {problem}"))
            }
            other => other.into(),
        };
        Ok((name.clone(), samples.map_err(about)?))
    };
    let mut samples = samples.into_iter().map(sampled).collect::<Result<Vec<_>, _>>()?;
    samples.sort_by(|a, b| a.0.cmp(&b.0));
    let given = Given { text, file, table, samples, hold, start, duration, sample, ignored };
    let system = model.get().system.clone();
    let (answer, run) = watched(py, move |stop| {
        let given = given.scenario(&system)?;
        let defaults = SimulationSettings::default();
        let settings = SimulationSettings {
            rtol: rtol.unwrap_or(defaults.rtol),
            atol: atol.unwrap_or(defaults.atol),
            stop: stop.clone(),
            ..defaults
        };
        let run = Arc::new(given.scenario.run(&system, &settings)?);
        let json = serde_json::to_string(&simulation::json(&system, &given, &run)).map_err(Failure::from)?;
        let text = simulation::text(&system, &given, &run);
        let drawn: Arc<ScenarioRun> = Arc::clone(&run);
        let figure = move || simulation::figure(&system, &given.scenario, &drawn);
        Ok((Answer { json, text, figures: Figures::default().with("trajectory", figure) }, run))
    })?;
    let system = &model.get().system;
    let dict = answer.into_dict(py)?;
    dict.set_item("t", run.times.clone().into_pyarray(py))?;
    dict.set_item("states", matrix(py, &run.states, system.states.len())?)?;
    dict.set_item("inputs", matrix(py, &run.inputs, system.inputs.len())?)?;
    dict.set_item("outputs", matrix(py, &run.outputs, system.outputs.len())?)?;
    Ok(dict)
}
