//! A diagnosis as the JSON object of `bracketry diagnose --json`.

use std::path::Path;

use bracketry_diagnose::{
    Audit, Candidate, Cause, Combination, Effort, Excess, Gain, NamedCause, Place, RefittedParameter, Report,
    ResidualAcceleration, Rival, Value, Verdict, Windows,
};
use bracketry_symbolic::Named;
use bracketry_system::TimeUnit;
use serde::{Serialize, Serializer};

use super::sentences::{closeness, flag, note, reason, regime};

/// A report with its reasons in sentences, to be serialized.
#[derive(Serialize)]
pub struct DiagnosisJson<'a> {
    model: &'a str,
    #[serde(skip_serializing_if = "TimeUnit::is_second")]
    time_unit: TimeUnit,
    verdict: Verdict,
    reason: String,
    causes: Vec<CauseJson<'a>>,
    #[serde(rename = "where")]
    places: Vec<PlaceJson<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    regimes: Vec<PlaceJson<'a>>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    residual_acceleration: &'a [ResidualAcceleration],
    #[serde(skip_serializing_if = "Option::is_none")]
    gain: Option<&'a Gain>,
    #[serde(serialize_with = "parameters")]
    parameters: &'a [RefittedParameter],
    #[serde(skip_serializing_if = "Option::is_none")]
    extended_model: Option<&'a Path>,
    #[serde(skip_serializing_if = "Option::is_none")]
    excess: Option<&'a Excess>,
    candidates: &'a [Candidate],
    #[serde(skip_serializing_if = "Option::is_none")]
    windows: Option<Windows>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    data: &'a [Audit],
    notes: Vec<String>,
    effort: Effort,
    seconds: f64,
}

#[derive(Serialize)]
struct CauseJson<'a> {
    name: Cause,
    equation: &'a str,
    term: &'a str,
    parameters: &'a Named<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p_value: Option<f64>,
    confusable_with: &'a [Cause],
    separating_experiment: &'a str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    rivals: Vec<RivalJson<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    share: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    flags: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    combination: Option<&'a Combination>,
}

#[derive(Serialize)]
struct RivalJson<'a> {
    name: Cause,
    equation: &'a str,
    term: &'a str,
    why: String,
}

#[derive(Serialize)]
struct PlaceJson<'a> {
    equation: &'a str,
    regime: String,
    share: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<f64>,
}

impl<'a> DiagnosisJson<'a> {
    /// Of a report, and of the file to which its extended model was written.
    pub fn of(report: &'a Report, extended_model: Option<&'a Path>) -> Self {
        Self {
            model: &report.model,
            time_unit: report.quantities.time_unit,
            verdict: report.verdict,
            reason: reason(&report.reason),
            causes: report.causes.iter().map(CauseJson::of).collect(),
            places: report.places.iter().map(PlaceJson::of).collect(),
            regimes: report.regimes.iter().map(PlaceJson::of).collect(),
            residual_acceleration: &report.residual_acceleration,
            gain: report.gain.as_ref(),
            parameters: &report.parameters,
            extended_model,
            excess: report.excess.as_ref(),
            candidates: &report.candidates,
            windows: report.windows,
            data: &report.data,
            notes: report.notes.iter().map(note).collect(),
            effort: report.effort,
            seconds: report.seconds,
        }
    }
}

impl<'a> CauseJson<'a> {
    fn of(cause: &'a NamedCause) -> Self {
        let of_rival = |rival: &'a Rival| RivalJson {
            name: rival.name,
            equation: &rival.equation,
            term: rival.term.text(),
            why: closeness(rival.closeness),
        };
        Self {
            name: cause.name,
            equation: &cause.equation,
            term: cause.term.text(),
            parameters: &cause.parameters,
            p_value: cause.p_value,
            confusable_with: &cause.confusable_with,
            separating_experiment: &cause.separating_experiment,
            rivals: cause.rivals.iter().map(of_rival).collect(),
            share: cause.share,
            flags: cause.flags.iter().map(flag).collect(),
            combination: cause.combination.as_ref(),
        }
    }
}

impl<'a> PlaceJson<'a> {
    fn of(place: &'a Place) -> Self {
        Self { equation: &place.equation, regime: regime(&place.regime), share: place.share, time: place.time }
    }
}

/// The list as an object by name, in its own order.
fn parameters<S: Serializer>(values: &[RefittedParameter], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(values.iter().map(|p| (&p.name, p)))
}
