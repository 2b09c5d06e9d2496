//! Lyapunov functions, regions of attraction, storage functions, conserved functions.

use std::sync::Arc;

use bracketry::certify::{Certificate, CertifyOptions, Find, check, portrait, with_feedback};
use bracketry::report::certificates::{certification_json, certification_text, check_text, region_figure};
use bracketry::system::System;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::Failure;
use crate::figures::Figures;
use crate::interrupt::{seconds, watched};
use crate::model::Model;
use crate::tables::Answer;

/// The model at a point with feedback.
fn closed(system: &System, at: Option<&str>, feedback: &[String]) -> Result<System, Failure> {
    let mut system = system.clone();
    if let Some(at) = at {
        system.point = Some(bracketry::point(&mut system, at).map_err(|e| Failure::from(e).about("at"))?);
    }
    with_feedback(&system, feedback).map_err(|e| Failure::from(e).about("feedback"))
}

fn sought(name: &str, system: &System) -> Result<Vec<Find>, Failure> {
    let ports = !system.inputs.is_empty() && system.inputs.len() == system.outputs.len();
    Ok(match name {
        "lyapunov" => vec![Find::Lyapunov],
        "region" => vec![Find::Region],
        "passivity" => vec![Find::Passivity],
        "conserved" => vec![Find::Conserved],
        "all" => {
            let mut all = vec![Find::Conserved, Find::Lyapunov, Find::Region];
            all.extend(ports.then_some(Find::Passivity));
            all
        }
        other => {
            return Err(Failure::new(format!(
                "find: `{other}` is not one of \"lyapunov\", \"region\", \"passivity\", \"conserved\", \"all\""
            )));
        }
    })
}

/// What is proved of a polynomial model at its point.
#[pyfunction]
#[pyo3(signature = (model, at, feedback, find, degree, time_limit))]
pub(crate) fn certify<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    at: Option<String>,
    feedback: Vec<String>,
    find: Vec<String>,
    degree: u32,
    time_limit: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let system = model.get().system.clone();
    let limit = seconds(time_limit)?;
    let answer = watched(py, move |stop| {
        let system = Arc::new(closed(&system, at.as_deref(), &feedback)?);
        let mut list = Vec::new();
        for name in &find {
            list.extend(sought(name, &system)?);
        }
        let options = CertifyOptions { find: list, degree, time_limit: Some(limit), stop: stop.clone() };
        let found = bracketry::certify::certify(&system, &options).map_err(|e| Failure::from(e).about("degree"))?;
        let mut figures = Figures::default();
        let proof = found.region.as_ref().and_then(|f| f.proof()).filter(|p| p.level.is_some());
        if let (Some(proof), true) = (proof, system.states.len() > 1) {
            let picture = portrait(&system, proof, [0, 1])?;
            let (name, quantities) = (system.name.clone(), system.quantities.clone());
            figures = figures.with("region", move || region_figure(&name, &quantities, &picture));
        }
        Answer::new(&certification_json(&found), certification_text(&found), figures)
    })?;
    answer.into_dict(py)
}

/// What a certificate, as JSON text, proves of a model: the conclusion, if any, and a sentence.
#[pyfunction]
#[pyo3(signature = (model, at, feedback, certificate))]
pub(crate) fn check_certificate(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    at: Option<String>,
    feedback: Vec<String>,
    certificate: String,
) -> PyResult<(Option<String>, String)> {
    let system = model.get().system.clone();
    watched(py, move |_| {
        let system = closed(&system, at.as_deref(), &feedback)?;
        let certificate: Certificate =
            serde_json::from_str(&certificate).map_err(|e| Failure::from(e).about("certificate"))?;
        let outcome = check(&system, &certificate);
        let conclusion = match &outcome {
            Ok(conclusion) => serde_json::to_value(conclusion)?.as_str().map(str::to_owned),
            Err(_) => None,
        };
        Ok((conclusion, check_text(&system.name, &outcome).trim_end().to_owned()))
    })
}
