//! What the inputs reach, and affine forms.

use std::sync::Arc;

use bracketry::lie::AnalysisOptions;
use bracketry::report::analysis::{self as report, AffinizationReport};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::watched;
use crate::model::Model;
use crate::tables::Answer;

/// What the inputs of a model reach.
#[pyfunction]
#[pyo3(signature = (model, at, brackets, determines))]
pub(crate) fn analyze<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    at: Option<String>,
    brackets: Vec<String>,
    determines: Vec<String>,
) -> PyResult<Bound<'py, PyDict>> {
    let mut system = model.get().system.clone();
    let (answer, markdown, latex, affine) = watched(py, move |stop| {
        system.pool.set_stop_flag(stop.clone());
        if let Some(at) = &at {
            system.point = Some(bracketry::point(&mut system, at).map_err(|e| Failure::from(e).about("at"))?);
        }
        let options = AnalysisOptions { brackets, determined: determines, ..AnalysisOptions::default() };
        let analysis = bracketry::analyze(&system, &options)?;
        let affine = Model::made(analysis.affinization.system.clone());
        let (markdown, latex) = (report::markdown(&analysis), report::latex(&analysis));
        let analysis = Arc::new(analysis);
        let mut figures = Figures::default();
        let drawn = Arc::clone(&analysis);
        figures = figures.with("growth", move || report::growth_figure(&drawn).draw());
        if let Some(reach) = report::reach_figure(&analysis) {
            figures = figures.with("reach", move || reach.draw());
        }
        Ok((Answer::new(&report::json(&analysis), report::text(&analysis), figures)?, markdown, latex, affine.ok()))
    })?;
    let dict = answer.into_dict(py)?;
    dict.set_item("markdown", markdown)?;
    dict.set_item("latex", latex)?;
    dict.set_item("affine_model", affine.map(|m| Py::new(py, m)).transpose()?)?;
    Ok(dict)
}

/// The model in a form that is affine in its inputs.
#[pyfunction]
pub(crate) fn affinize<'py>(py: Python<'py>, model: &Bound<'py, Model>) -> PyResult<Bound<'py, PyDict>> {
    let system = model.get().system.clone();
    let (json, changes, affine) = watched(py, move |_| {
        let affinization = system.affinize()?;
        let json = serde_json::to_string(&AffinizationReport::new(&affinization, None))?;
        Ok((json, report::changes(&affinization), Model::made(affinization.system)?))
    })?;
    let dict = PyDict::new(py);
    dict.set_item("json", json)?;
    dict.set_item("changes", changes)?;
    dict.set_item("model", Py::new(py, affine)?)?;
    Ok(dict)
}
