//! Operating points and linear systems.

use bracketry::lie::operating::{LinearizeOptions, TrimOptions};
use bracketry::report::operating::{linear_files, linear_json, linear_text, trim_json, trim_text};
use bracketry::system::System;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::watched;
use crate::model::Model;
use crate::tables::Answer;

/// What an operating point is asked for: names with values, inputs to search, states that may move, starts, seed.
type Asked = (Vec<(String, String)>, Vec<String>, Vec<String>, usize, u64);

fn options(system: &mut System, (fixed, free, moving, starts, seed): Asked) -> Result<TrimOptions, Failure> {
    let mut options = TrimOptions { free, moving, starts: starts.min(1000), seed, ..TrimOptions::default() };
    for (name, value) in fixed {
        let at = bracketry::point(system, &format!("{name}={value}")).map_err(|e| Failure::from(e).about("fix"))?;
        let place = system.state_index(&name).map(|k| at.states[k]);
        if let Some(value) = place.or_else(|| system.input_index(&name).map(|k| at.inputs[k])) {
            options.fixed.push((name, value));
        }
    }
    Ok(options)
}

/// An operating point of a model, and the model with its point there.
#[pyfunction]
pub(crate) fn trim<'py>(py: Python<'py>, model: &Bound<'py, Model>, asked: Asked) -> PyResult<Bound<'py, PyDict>> {
    let mut system = model.get().system.clone();
    let (answer, there) = watched(py, move |_| {
        let options = options(&mut system, asked)?;
        let found = bracketry::lie::trim(&system, &options)?;
        system.point = Some(found.point(&mut system));
        let text = trim_text(&system.name, &found);
        let answer = Answer::new(&trim_json(&system.name, &found), text, Figures::default())?;
        Ok((answer, Model::made(system)?))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("model", Py::new(py, there)?)?;
    Ok(dict)
}

/// The linear system at the model's point, or at another one.
#[pyfunction]
#[pyo3(signature = (model, at, weights, horizon))]
pub(crate) fn linearize<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    at: Option<String>,
    weights: [Vec<f64>; 4],
    horizon: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut system = model.get().system.clone();
    let (answer, files) = watched(py, move |_| {
        if let Some(at) = &at {
            system.point = Some(bracketry::point(&mut system, at).map_err(|e| Failure::from(e).about("at"))?);
        }
        let [state_weights, input_weights, process_noise, measurement_noise] = weights;
        let options = LinearizeOptions { state_weights, input_weights, process_noise, measurement_noise, horizon };
        let found = bracketry::lie::linearize(&system, &options)?;
        let files: Vec<(String, String)> =
            linear_files(&found.system).into_iter().map(|f| (f.name.to_owned(), f.text)).collect();
        Ok((Answer::new(&linear_json(&found), linear_text(&found), Figures::default())?, files))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("files", files)?;
    Ok(dict)
}
