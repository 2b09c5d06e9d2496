//! The analysis as one JSON object.

use std::collections::BTreeMap;

use bracketry_lie::{Analysis, Report};
use serde::Serialize;

use super::affinization::AffinizationReport;
use super::summary::summary;

/// An analysis as it is serialized, see [`json`].
#[derive(Serialize)]
pub struct AnalysisJson<'a> {
    model: &'a str,
    states: usize,
    inputs: usize,
    affine: bool,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    input_delays: &'a BTreeMap<String, f64>,
    affinization: AffinizationReport,
    #[serde(flatten)]
    report: &'a Report,
    summary: String,
}

/// What `bracketry analyze --json` prints.
pub fn json(a: &Analysis) -> AnalysisJson<'_> {
    AnalysisJson {
        model: &a.model,
        states: a.states,
        inputs: a.inputs,
        affine: a.affine,
        input_delays: &a.input_delays,
        affinization: AffinizationReport::new(&a.affinization, a.family.as_ref()),
        report: &a.report,
        summary: summary(a),
    }
}
