//! How a model became affine in its inputs.

use bracketry_lie::analysis::Family;
use bracketry_system::{AffineReason, Affinization, AtPoint, Candidate, Method, NewState, System, counted};
use serde::Serialize;

/// A new input.
#[derive(Clone, Debug, Serialize)]
pub struct InputChange {
    /// Its name.
    pub name: String,
    /// The function of the old inputs that it stands for.
    pub function: String,
    /// The values that it can take, where they are limited.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<String>,
    /// Where its value at the point lies among these.
    pub at_point: AtPoint,
}

/// How the model became affine in its inputs.
#[derive(Clone, Debug, Serialize)]
pub struct AffinizationReport {
    /// What was done.
    pub method: Method,
    /// Integrators in front of each input that got any.
    pub integrators: std::collections::BTreeMap<String, u32>,
    /// Each new input with its function of the old ones and its range, where that is limited.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub input_change: Vec<InputChange>,
    /// New states that replace old ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coordinate_change: Vec<NewState>,
    /// Where the ranges of the new inputs say less than those of the old ones.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub range_notes: Vec<String>,
    /// The affine model.
    pub model: System,
    /// The reason.
    pub why: AffineReason,
    /// All candidates, accepted ones first; none for a model that is affine as written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub candidates: Vec<Candidate>,
    /// What the original reaches with constant inputs, which the affine form must agree with; absent for a model that is
    /// affine as it stands, and as long as no analysis was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub family: Option<Family>,
}

impl AffinizationReport {
    /// The affine form with the family of constant inputs, where that was looked at.
    pub fn new(a: &Affinization, family: Option<&Family>) -> Self {
        AffinizationReport {
            method: a.method,
            integrators: a.integrators.clone(),
            input_change: a
                .input_change
                .iter()
                .map(|v| InputChange {
                    name: v.name.clone(),
                    function: a.system.pool.text(v.function),
                    range: v.range(),
                    at_point: v.at_point,
                })
                .collect(),
            coordinate_change: a.coordinate_change.clone(),
            range_notes: a.range_notes.iter().map(ToString::to_string).collect(),
            model: a.system.clone(),
            why: a.why.clone(),
            candidates: if a.method == Method::None { Vec::new() } else { a.candidates.clone() },
            family: family.cloned(),
        }
    }
}

/// A candidate for an affine form in words.
pub fn method_name(method: Method) -> &'static str {
    match method {
        Method::None => "already affine",
        Method::InputChange => "new inputs",
        Method::Feedback => "new inputs that depend on the state",
        Method::InputAugmentation => "integrators",
        Method::CoordinateChange => "new states",
    }
}

/// New inputs and new states in short, then what their ranges do not say; one line each, in formulas of the model file.
pub fn changes(a: &Affinization) -> Vec<String> {
    let inputs = a.input_change.iter().map(|v| {
        let range = v.range().map_or(String::new(), |r| format!(", limited to {r}"));
        format!("new input {} = {}{range}", v.name, a.system.pool.text(v.function))
    });
    let states = a.coordinate_change.iter().map(|z| {
        let (function, inverse) = (z.function.text(), z.inverse.text());
        format!("new state {} = {function} replaces {} = {inverse}", z.name, z.replaces)
    });
    let no_point = (a.system.point.is_some() && !a.system.point_is_finite())
        .then(|| "the affine model has no point: at the model's point, a new input has no finite value".to_owned());
    inputs.chain(states).chain(a.range_notes.iter().map(ToString::to_string)).chain(no_point).collect()
}

/// The reason, and where there is a choice all candidates, numbered from 1, one line each; `asked` is the one that is taken
/// instead of the one that adds the fewest states.
pub fn candidates(a: &Affinization, asked: Option<&Candidate>) -> Vec<String> {
    let taken = asked.filter(|c| !c.chosen);
    let mut lines = vec![taken.map_or_else(|| a.why.to_string(), |c| c.why.to_string())];
    if a.candidates.len() > 1 {
        lines.extend(a.candidates.iter().enumerate().map(|(k, c)| format!("{}. {}", k + 1, candidate(c, a, taken))));
    }
    lines
}

fn candidate(c: &Candidate, a: &Affinization, taken: Option<&Candidate>) -> String {
    let method = method_name(c.method);
    if !c.is_accepted() {
        return format!("{method}, rejected: {}", c.why);
    }
    let states = match c.added_states {
        0 => "no state".to_owned(),
        n => counted(n, "state", "states"),
    };
    // The reason of the one taken stands above.
    let why = match taken {
        Some(taken) if std::ptr::eq(taken, c) => "selected by its number".to_owned(),
        None if c.chosen && c.why == a.why => "selected".to_owned(),
        _ => c.why.to_string(),
    };
    format!("{method}, adds {states}: {why}")
}
