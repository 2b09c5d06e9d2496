//! JSON of operating points and linear systems.

use bracketry_lie::operating::{LinearAnalysis, Trim, TrimNote, TrimStatus, TrimValue};
use serde::Serialize;
use serde_json::{Map, Value, json};

use super::text::note;

/// An operating point: status, values by name, residual, and notes.
pub fn trim_json(model: &str, trim: &Trim) -> Value {
    let values = |list: &[TrimValue]| -> Map<String, Value> {
        list.iter()
            .map(|v| {
                let mut entry = json!({"value": v.value, "role": v.role});
                if let (Some(exact), Some(entry)) = (&v.exact, entry.as_object_mut()) {
                    entry.insert("exact".into(), Value::String(exact.text()));
                }
                (v.name.clone(), entry)
            })
            .collect()
    };
    let derivatives: Map<String, Value> = trim.derivatives.iter().map(|(n, v)| (n.clone(), json!(v))).collect();
    let mut out = json!({
        "model": model,
        "status": trim.status,
        "found": trim.status == TrimStatus::Found,
        "states": values(&trim.states),
        "inputs": values(&trim.inputs),
        "derivatives": derivatives,
        "residual": trim.residual,
        "exact": trim.exact,
        "notes": trim.notes.iter().map(noted).collect::<Vec<_>>(),
    });
    if let (false, Some(out)) = (trim.others.is_empty(), out.as_object_mut()) {
        let names = trim.states.iter().chain(&trim.inputs).map(|v| v.name.as_str());
        let names: Vec<&str> = names.collect();
        let other = |values: &Vec<f64>| -> Map<String, Value> {
            names.iter().zip(values).map(|(n, v)| ((*n).to_owned(), json!(v))).collect()
        };
        out.insert("others".into(), trim.others.iter().map(other).map(Value::Object).collect());
    }
    out
}

/// The note as data, with its text.
fn noted(n: &TrimNote) -> Value {
    let mut value = json!(n);
    if let Some(entry) = value.as_object_mut() {
        entry.insert("text".into(), Value::String(note(n)));
    }
    value
}

#[derive(Serialize)]
struct Failed {
    reason: String,
}

/// A linear system; an absent gain is an object with its `reason`.
pub fn linear_json(analysis: &LinearAnalysis) -> Value {
    let mut out = json!(analysis);
    if let Some(entries) = out.as_object_mut() {
        for (key, gain) in [("regulator", &analysis.regulator), ("estimator", &analysis.estimator)] {
            let value = match gain {
                Ok(gain) => json!(gain),
                Err(why) => json!(Failed { reason: why.to_string() }),
            };
            entries.insert(key.into(), value);
        }
    }
    out
}
