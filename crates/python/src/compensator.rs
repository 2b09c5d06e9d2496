//! The compensation of a robot's deformation, stepped from Python.

use std::sync::Mutex;

use bracketry::report::stiffness::text;
use bracketry::stiffness::{Compensator as Stepped, Wrench};
use numpy::{AllowTypeChange, IntoPyArray, PyArray1, PyArrayLike1};
use pyo3::prelude::*;

use crate::error::Failure;
use crate::stiffness::robot_file;
use crate::tables::Text;

/// Numbers from whatever NumPy makes an array of.
type Numbers<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

/// The compensation of a robot.
#[pyclass(frozen, module = "bracketry._native")]
pub(crate) struct Compensator(Mutex<Stepped>);

/// What a step gives.
#[pyclass(frozen, get_all, module = "bracketry._native")]
pub(crate) struct CompensationStep {
    /// Corrected reference of the joints, rad or m.
    reference: Py<PyArray1<f64>>,
    /// The correction in force, rad or m.
    correction: Py<PyArray1<f64>>,
    /// Filtered process wrench at the tool point in base axes, N and N·m.
    wrench: Py<PyArray1<f64>>,
    /// Displacement of the tool point without correction in base axes, m and rad.
    displacement: Py<PyArray1<f64>>,
    /// What was wrong with the input; the last good correction is held then.
    fault: Option<String>,
    /// Whether a limit shortened the correction or its change.
    limited: bool,
}

#[pymethods]
impl Compensator {
    #[new]
    fn new(py: Python<'_>, robot: Text, period: Option<f64>) -> Result<Self, Failure> {
        py.detach(|| Ok(Self(Mutex::new(robot_file(&robot)?.compensator(period)?))))
    }

    fn step(
        &self,
        py: Python<'_>,
        measured: Numbers<'_>,
        reading: [f64; 6],
        reference: Numbers<'_>,
    ) -> Result<CompensationStep, Failure> {
        let (measured, reference) = (measured.as_array().to_vec(), reference.as_array().to_vec());
        let mut stepped = self.0.lock().map_err(|_| Failure::new("the compensation has failed; create a new one"))?;
        let step = stepped.step(&measured, &Wrench::from(reading), &reference);
        Ok(CompensationStep {
            reference: step.reference.to_vec().into_pyarray(py).unbind(),
            correction: step.correction.to_vec().into_pyarray(py).unbind(),
            wrench: step.wrench.as_slice().to_vec().into_pyarray(py).unbind(),
            displacement: step.displacement.as_slice().to_vec().into_pyarray(py).unbind(),
            fault: step.status.fault.map(text::fault),
            limited: step.status.saturated || step.status.rate_limited,
        })
    }
}
