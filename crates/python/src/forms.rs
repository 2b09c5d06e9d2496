//! Normal forms and decompositions.

use bracketry::lie::forms::{Form, TransformOptions};
use bracketry::report::forms::{transformation_json, transformation_text};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::{seconds, watched};
use crate::model::Model;
use crate::tables::Answer;

/// A model in another form, with its parts by name.
#[pyfunction]
#[pyo3(signature = (model, to, at, outputs, time_limit))]
pub(crate) fn transform<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    to: String,
    at: Option<String>,
    outputs: Vec<String>,
    time_limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let mut system = model.get().system.clone();
    let limit = seconds(time_limit)?;
    let (answer, made, parts) = watched(py, move |flag| {
        system.pool.set_stop_flag(flag.clone());
        let form: Form = to.parse()?;
        if let Some(at) = &at {
            system.point = Some(bracketry::point(&mut system, at).map_err(|e| Failure::from(e).about("at"))?);
        }
        let options = TransformOptions { outputs, time_limit: Some(limit) };
        let result = bracketry::lie::transform(&system, form, &options)?;
        let answer = Answer::new(&transformation_json(&result), transformation_text(&result), Figures::default())?;
        let mut parts = Vec::new();
        let mut made = None;
        if let Some(found) = result.found() {
            made = Some(Model::made(found.system.clone())?);
            for part in &found.parts {
                parts.push((part.kind.name().to_owned(), Model::made(part.system.clone())?));
            }
        }
        Ok((answer, made, parts))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("model", made.map(|m| Py::new(py, m)).transpose()?)?;
    let parts: Vec<(String, Py<Model>)> =
        parts.into_iter().map(|(name, m)| Ok((name, Py::new(py, m)?))).collect::<PyResult<_>>()?;
    dict.set_item("parts", parts)?;
    Ok(dict)
}
