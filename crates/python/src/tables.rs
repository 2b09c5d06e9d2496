//! Rows of numbers as arrays, tables as texts.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

use bracketry::sim::Hold;
use bracketry::system::{Columns, Document};
use numpy::{PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;

/// A matrix of `columns` columns from rows of that length.
pub(crate) fn matrix<'py>(py: Python<'py>, rows: &[Vec<f64>], columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    if rows.is_empty() || columns == 0 {
        return Ok(PyArray2::zeros(py, [rows.len(), columns], false));
    }
    Ok(PyArray2::from_vec2(py, rows)?)
}

/// Columns by name from one-dimensional arrays.
pub(crate) fn columns(arrays: HashMap<String, PyReadonlyArray1<'_, f64>>) -> BTreeMap<String, Vec<f64>> {
    arrays.into_iter().map(|(name, values)| (name, values.as_array().to_vec())).collect()
}

/// A text in a file, or given with a name for messages.
#[derive(FromPyObject)]
pub(crate) enum Text {
    /// A file.
    File(PathBuf),
    /// Name and text.
    Given(String, String),
}

impl Text {
    /// The document of a table; `what` says what to name where a file is none.
    pub(crate) fn table(&self, what: &str) -> Result<Document, Failure> {
        match self {
            Text::File(path) => Ok(Columns::document(path, what)?),
            Text::Given(name, text) => Ok(Document::new(name, text)),
        }
    }

    /// Name and text.
    pub(crate) fn contents(&self) -> Result<(String, String), Failure> {
        match self {
            Text::File(path) => {
                let text = std::fs::read_to_string(path);
                let text = text.map_err(|e| Failure::from(e).about(&path.display().to_string()))?;
                Ok((path.display().to_string(), text))
            }
            Text::Given(name, text) => Ok((name.clone(), text.clone())),
        }
    }
}

/// What every result has: its JSON object, its text, its figures.
pub(crate) struct Answer {
    pub(crate) json: String,
    pub(crate) text: String,
    pub(crate) figures: Figures,
}

impl Answer {
    pub(crate) fn of(report: &(impl serde::Serialize + ToString), figures: Figures) -> Result<Self, Failure> {
        Self::new(report, report.to_string(), figures)
    }

    pub(crate) fn new(json: &impl serde::Serialize, text: String, figures: Figures) -> Result<Self, Failure> {
        Ok(Self { json: serde_json::to_string(json)?, text, figures })
    }

    pub(crate) fn into_dict(self, py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let dict = PyDict::new(py);
        dict.set_item("json", self.json)?;
        dict.set_item("text", self.text)?;
        dict.set_item("figures", Py::new(py, self.figures)?)?;
        Ok(dict)
    }
}

/// How samples go on: `"previous"` or `"linear"`.
pub(crate) fn hold(name: &str) -> Result<Hold, Failure> {
    match name {
        "previous" => Ok(Hold::Previous),
        "linear" => Ok(Hold::Linear),
        other => Err(Failure::new(format!("hold is \"{other}\"; it can be \"previous\" or \"linear\""))),
    }
}
