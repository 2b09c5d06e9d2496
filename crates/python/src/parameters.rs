//! Verdicts by cases of parameters, and identifiability.

use std::sync::Arc;

use bracketry::lie::observability::IdentifiabilityOptions;
use bracketry::lie::parameters::{ParameterOptions, ParameterRange};
use bracketry::report::identifiability::{identifiability_json, identifiability_text};
use bracketry::report::parameters::{
    parameter_figure, parameter_json, parameter_map_json, parameter_map_text, parameter_text,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::figures::Figures;
use crate::interrupt::watched;
use crate::model::Model;
use crate::tables::Answer;

/// For which values of the parameters the verdicts differ from those for generic values.
#[pyfunction]
pub(crate) fn parameter_cases<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    parameters: Vec<String>,
    conditions: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let mut system = model.get().system.clone();
    let answer = watched(py, move |stop| {
        system.pool.set_stop_flag(stop.clone());
        let options = ParameterOptions { parameters, conditions: conditions.max(1), ..ParameterOptions::default() };
        let report = bracketry::lie::parameter_cases(&system, &options)?;
        Answer::new(&parameter_json(&report), parameter_text(&report), Figures::default())
    })?;
    answer.into_dict(py)
}

/// Verdicts over two parameters.
#[pyfunction]
pub(crate) fn parameter_map<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    ranges: String,
    cells: usize,
    conditions: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let mut system = model.get().system.clone();
    let answer = watched(py, move |stop| {
        system.pool.set_stop_flag(stop.clone());
        let options = ParameterOptions { conditions: conditions.max(1), ..ParameterOptions::default() };
        let ranges = ParameterRange::two(&ranges)?;
        let map = Arc::new(bracketry::lie::parameter_map(&system, &ranges, cells, &options)?);
        let drawn = Arc::clone(&map);
        let quantities = system.all_quantities();
        let figures = Figures::default().with("map", move || parameter_figure(&quantities, &drawn).draw());
        Answer::new(&parameter_map_json(&map), parameter_map_text(&map), figures)
    })?;
    answer.into_dict(py)
}

/// Local and global identifiability.
#[pyfunction]
pub(crate) fn identifiability<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    known_initial: Vec<String>,
    unknown_inputs: Vec<String>,
    global: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let mut system = model.get().system.clone();
    let answer = watched(py, move |stop| {
        system.pool.set_stop_flag(stop.clone());
        let options =
            IdentifiabilityOptions { known_initial, unknown_inputs, global, ..IdentifiabilityOptions::default() };
        let report = bracketry::lie::identifiability(&system, &options)?;
        Answer::new(&identifiability_json(&report), identifiability_text(&report), Figures::default())
    })?;
    answer.into_dict(py)
}
