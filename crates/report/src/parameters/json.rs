//! JSON of verdicts by cases of parameters.

use bracketry_lie::parameters::{AspectCases, ParameterMap, ParameterReport};
use serde_json::{Map, Value, json};

fn aspect(a: &AspectCases) -> Value {
    let mut out = json!(a);
    if let (Some(entry), Some(reason)) = (out.as_object_mut(), a.generic.reason()) {
        entry.insert("reason".into(), Value::String(reason.to_string()));
    }
    if let Some(cases) = out.get_mut("cases").and_then(Value::as_array_mut) {
        for (entry, case) in cases.iter_mut().zip(&a.cases) {
            let solved: Map<String, Value> = case.solved.iter().map(|(n, f)| (n.clone(), json!(f))).collect();
            entry["solved"] = Value::Object(solved);
        }
    }
    out
}

/// The cases of each aspect.
pub fn parameter_json(report: &ParameterReport) -> Value {
    let mut out = json!(report);
    out["aspects"] = report.aspects.iter().map(aspect).collect();
    out["fixed"] = Value::Object(report.fixed.iter().map(|(n, v)| (n.clone(), json!(v))).collect());
    out["complete"] = json!(report.is_complete());
    out
}

/// A map with its exact cases.
pub fn parameter_map_json(map: &ParameterMap) -> Value {
    let mut out = json!(map);
    out["report"] = parameter_json(&map.report);
    out
}
