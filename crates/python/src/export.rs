//! Models as source code.

use bracketry::export::{ExportOptions, KeptParameters};
use bracketry::report::export::{export_json, export_text};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::model::Model;
use crate::tables::Answer;

/// The equations with their Jacobians in a language; `source` is everything as one file.
#[pyfunction]
#[pyo3(signature = (model, language, parameters, name))]
pub(crate) fn export<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    language: String,
    parameters: Vec<String>,
    name: Option<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let system = &model.get().system;
    let (answer, source) = py.detach(|| -> Result<_, Failure> {
        let parameters = KeptParameters::from_names(parameters);
        let options = ExportOptions { target: language.parse()?, parameters, name };
        let made = bracketry::export::export(system, &options)?;
        Ok((Answer::new(&export_json(&made), export_text(&made), Figures::default())?, made.single))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("source", source)?;
    Ok(dict)
}
