//! Controllers of problems, stepped from Python.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};

use bracketry::mpc::closed_loop::Counts;
use bracketry::mpc::controller::FallbackReason;
use bracketry::mpc::{LiveController as Live, MpcError};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::control::{models_of, read};
use crate::error::Failure;
use crate::interrupt::watched;
use crate::model::Model;
use crate::tables::matrix;

/// Numbers as they come most often; the package makes these of everything else.
#[derive(FromPyObject)]
enum Numbers<'py> {
    Array(PyReadonlyArray1<'py, f64>),
    List(Vec<f64>),
}

/// A controller and the outcomes of its samples.
struct Counted {
    live: Live,
    counts: Counts,
}

/// The controller of a problem. Everything that takes time releases the interpreter.
#[pyclass(frozen, module = "bracketry._native")]
pub(crate) struct LiveController(Mutex<Counted>);

/// One sample's input.
#[pyclass(frozen, get_all, module = "bracketry._native")]
pub(crate) struct Step {
    /// Input to hold over the next period.
    u: Py<PyArray1<f64>>,
    /// Outcome of the sample.
    status: String,
    /// Why the failure policy decided.
    reason: Option<String>,
    /// Where the input comes from.
    source: String,
    /// Number of the sample.
    sample: usize,
    /// Samples before it without a measurement.
    missed: usize,
    /// Estimated states.
    estimate: Option<Py<PyArray1<f64>>>,
    /// The states less what the plan before predicted.
    innovation: Option<Py<PyArray1<f64>>>,
    /// Residual of the conditions of optimality.
    residual: Option<f64>,
    /// Programs that were solved, and iterations of interior-point methods.
    programs: usize,
    iterations: usize,
    /// Time from the measurement to the input, s.
    feedback_seconds: f64,
    /// Time of the preparation, s.
    prepare_seconds: f64,
}

/// What a step is made of, in the order of its attributes: up to the samples missed, then from the estimate on.
type Outcome = (Py<PyArray1<f64>>, String, Option<String>, String, usize, usize);
type Figures = (Option<Py<PyArray1<f64>>>, Option<Py<PyArray1<f64>>>, Option<f64>, usize, usize, f64, f64);

#[pymethods]
impl Step {
    #[new]
    fn new(outcome: Outcome, figures: Figures) -> Self {
        let (u, status, reason, source, sample, missed) = outcome;
        let (estimate, innovation, residual, programs, iterations, feedback_seconds, prepare_seconds) = figures;
        Self {
            u,
            status,
            reason,
            source,
            sample,
            missed,
            estimate,
            innovation,
            residual,
            programs,
            iterations,
            feedback_seconds,
            prepare_seconds,
        }
    }

    /// For pickle and copy.
    fn __getnewargs__(&self, py: Python<'_>) -> (Outcome, Figures) {
        let array = |a: &Py<PyArray1<f64>>| a.clone_ref(py);
        let (status, reason, source) = (self.status.clone(), self.reason.clone(), self.source.clone());
        let (estimate, innovation) = (self.estimate.as_ref().map(array), self.innovation.as_ref().map(array));
        let seconds = (self.feedback_seconds, self.prepare_seconds);
        (
            (array(&self.u), status, reason, source, self.sample, self.missed),
            (estimate, innovation, self.residual, self.programs, self.iterations, seconds.0, seconds.1),
        )
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let reason = self.reason.as_ref().map_or_else(String::new, |r| format!(", reason={r:?}"));
        Ok(format!(
            "Step(u={}, status={:?}{reason}, source={:?}, sample={})",
            self.u.bind(py).repr()?,
            self.status,
            self.source,
            self.sample
        ))
    }
}

impl LiveController {
    fn lock(&self) -> Result<MutexGuard<'_, Counted>, Failure> {
        self.0.lock().map_err(|_| Failure::new("the controller has failed and cannot continue; create a new one"))
    }

    /// Does something that takes time without holding the interpreter.
    fn free<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Counted) -> Result<T, MpcError> + Send,
    ) -> Result<T, Failure> {
        py.detach(|| Ok(work(&mut *self.lock()?)?))
    }

    /// A sample.
    fn answered(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Live) -> Result<(), MpcError> + Send,
    ) -> Result<Step, Failure> {
        let (answer, estimate) = self.free(py, |c| {
            work(&mut c.live)?;
            c.counts.add(&c.live.last().step);
            Ok((c.live.last().clone(), c.live.estimate().map(|e| e.x.clone())))
        })?;
        let (step, sample, missed) = (answer.step, answer.sample, answer.missed);
        let innovation = (!answer.innovation.is_empty()).then_some(answer.innovation);
        Ok(Step {
            status: step.status.name().to_owned(),
            reason: step.status.fallback_reason().map(|reason| FallbackReason::name(reason).to_owned()),
            source: step.source.name().to_owned(),
            sample,
            missed,
            feedback_seconds: step.timings.feedback(),
            prepare_seconds: step.timings.linearize,
            innovation: innovation.map(|x| x.into_pyarray(py).unbind()),
            residual: step.residual,
            programs: step.effort.programs,
            iterations: step.effort.interior_point_steps,
            u: step.u.into_pyarray(py).unbind(),
            estimate: estimate.map(|x| x.into_pyarray(py).unbind()),
        })
    }
}

fn numbers(given: Numbers<'_>) -> Vec<f64> {
    match given {
        Numbers::Array(array) => array.as_array().to_vec(),
        Numbers::List(list) => list,
    }
}

#[pymethods]
impl LiveController {
    #[new]
    #[pyo3(signature = (*, path, text, folder, models, log))]
    fn new(
        py: Python<'_>,
        path: Option<PathBuf>,
        text: Option<String>,
        folder: PathBuf,
        models: HashMap<String, Bound<'_, Model>>,
        log: usize,
    ) -> PyResult<Self> {
        let models = models_of(&models);
        let live = watched(py, move |stop| {
            let mut problem = read(path.as_deref(), text.as_deref(), &folder, &models)?;
            problem.stop = stop.clone();
            let mut live = problem.controller()?;
            if log > 0 {
                live.keep_log(log);
            }
            Ok(live)
        })?;
        Ok(Self(Mutex::new(Counted { live, counts: Counts::default() })))
    }

    fn step(&self, py: Python<'_>, y: Numbers<'_>, t: Option<f64>) -> Result<Step, Failure> {
        let y = numbers(y);
        self.answered(py, move |live| match t {
            Some(t) => live.step_at(&y, t).map(|_| ()),
            None => live.step(&y).map(|_| ()),
        })
    }

    fn feedback(&self, py: Python<'_>, y: Numbers<'_>) -> Result<Step, Failure> {
        let y = numbers(y);
        self.answered(py, move |live| live.feedback(&y).map(|_| ()))
    }

    fn lost(&self, py: Python<'_>) -> Result<Step, Failure> {
        self.answered(py, |live| live.lost().map(|_| ()))
    }

    fn prepare(&self, py: Python<'_>) -> Result<(), Failure> {
        self.free(py, |c| c.live.prepare())
    }

    fn reset(&self, py: Python<'_>, x0: Option<Numbers<'_>>) -> Result<(), Failure> {
        let x0 = x0.map(numbers);
        self.free(py, move |c| {
            c.counts = Counts::default();
            match x0 {
                Some(x0) => c.live.reset_to(&x0),
                None => c.live.reset(),
            }
        })
    }

    fn set_reference(&self, py: Python<'_>, name: &str, value: f64) -> Result<(), Failure> {
        self.free(py, |c| c.live.set_reference(name, value))
    }

    fn set_reference_ahead(&self, py: Python<'_>, name: &str, values: Numbers<'_>) -> Result<(), Failure> {
        let values = numbers(values);
        self.free(py, move |c| c.live.set_reference_ahead(name, &values))
    }

    fn set_parameters(&self, py: Python<'_>, values: Vec<(String, f64)>) -> Result<(), Failure> {
        let values: Vec<(&str, f64)> = values.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        self.free(py, |c| c.live.set_parameters(&values))
    }

    fn set_bounds(&self, py: Python<'_>, name: &str, min: f64, max: f64) -> Result<(), Failure> {
        self.free(py, |c| c.live.set_bounds(name, min, max))
    }

    fn set_target(&self, py: Python<'_>, name: &str, value: f64) -> Result<(), Failure> {
        self.free(py, |c| c.live.set_target(name, value))
    }

    /// Times, states and inputs that the last plan predicts.
    fn predict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (t, plan) = self.free(py, |c| Ok((c.live.prediction_times(), c.live.prediction().clone())))?;
        let x: Vec<Vec<f64>> = (0..=plan.steps()).map(|k| plan.x(k).to_vec()).collect();
        let u: Vec<Vec<f64>> = (0..plan.steps()).map(|k| plan.u(k).to_vec()).collect();
        let dict = PyDict::new(py);
        dict.set_item("t", t.into_pyarray(py))?;
        dict.set_item("states", matrix(py, &x, plan.states())?)?;
        dict.set_item("inputs", matrix(py, &u, plan.inputs())?)?;
        Ok(dict)
    }

    /// Cost of the last plan over the horizon.
    #[getter]
    fn predicted_cost(&self, py: Python<'_>) -> Result<f64, Failure> {
        self.free(py, |c| Ok(c.live.predicted_cost()))
    }

    /// Slacks of the soft bounds along the last plan.
    fn slacks(&self, py: Python<'_>) -> Result<HashMap<String, f64>, Failure> {
        self.free(py, |c| {
            let mut largest = HashMap::new();
            for (name, slack) in c.live.slacks() {
                let entry: &mut f64 = largest.entry(name).or_insert(0.0);
                *entry = entry.max(slack);
            }
            Ok(largest)
        })
    }

    /// The kept samples: names of columns and a row per sample.
    fn log<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(log) = self.free(py, |c| Ok(c.live.log().cloned()))? else { return Ok(None) };
        let dict = PyDict::new(py);
        for (j, name) in log.names().iter().enumerate() {
            dict.set_item(name, log.rows().map(|row| row[j]).collect::<Vec<f64>>().into_pyarray(py))?;
        }
        Ok(Some(dict))
    }

    /// Outcomes of the samples since the last reset, as a JSON object.
    fn counts(&self, py: Python<'_>) -> PyResult<String> {
        let counts = self.free(py, |c| Ok(c.counts))?;
        Ok(serde_json::to_string(&counts).map_err(Failure::from)?)
    }

    #[getter]
    fn period(&self, py: Python<'_>) -> Result<f64, Failure> {
        self.free(py, |c| Ok(c.live.period()))
    }

    #[getter]
    fn delay(&self, py: Python<'_>) -> Result<usize, Failure> {
        self.free(py, |c| Ok(c.live.compensated_delay()))
    }

    #[getter]
    fn measured(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        self.free(py, |c| Ok(c.live.measured()))
    }

    #[getter]
    fn states(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        self.free(py, |c| Ok(c.live.states()))
    }

    #[getter]
    fn inputs(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        self.free(py, |c| Ok(c.live.inputs()))
    }

    #[getter]
    fn references(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        self.free(py, |c| Ok(c.live.references()))
    }

    #[getter]
    fn parameters(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        self.free(py, |c| Ok(c.live.parameters()))
    }

    #[getter]
    fn targets(&self, py: Python<'_>) -> Result<Vec<String>, Failure> {
        self.free(py, |c| Ok(c.live.targets()))
    }
}
