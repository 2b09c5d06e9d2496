//! The report against what is known.

use serde_json::Value;

use crate::model::Expected;

/// How an answer compares with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Judgment {
    Right,
    Unknown,
    Wrong,
}

/// The entry at a path, and how it compares; `None` where the report has no such entry.
pub(crate) fn judge(report: &Value, path: &str, expected: &Expected) -> (Judgment, Option<Value>) {
    let mut found = report;
    for key in path.split('.') {
        let next = match found {
            Value::Array(list) => key.parse::<usize>().ok().and_then(|i| list.get(i)),
            Value::Object(map) => map.get(key),
            _ => None,
        };
        match next {
            Some(next) => found = next,
            None => return (Judgment::Unknown, None),
        }
    }
    let text = found.as_str().unwrap_or_default();
    let judgment =
        if matches!(text, "unknown" | "inconclusive") { Judgment::Unknown } else { compare(found, expected) };
    (judgment, Some(found.clone()))
}

fn compare(found: &Value, expected: &Expected) -> Judgment {
    let right = |yes: bool| if yes { Judgment::Right } else { Judgment::Wrong };
    match expected {
        Expected::Is(value) => right(found == value),
        Expected::Count(count) => match found.as_array().map(Vec::len) {
            Some(n) if n < *count => Judgment::Unknown,
            n => right(n == Some(*count)),
        },
        Expected::Spectrum(expected) => {
            let mut found = eigenvalues(found);
            let near = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).abs() + (a.1 - b.1).abs() < 1e-6;
            let all = expected.iter().all(|e| {
                let place = found.iter().position(|f| near(f, e));
                place.map(|i| found.remove(i)).is_some()
            });
            right(all && found.is_empty())
        }
        Expected::Near(value) => {
            right(found.as_f64().is_some_and(|found| (found - value).abs() < 2e-3 * (1.0 + value.abs())))
        }
        Expected::Set(texts) => {
            let list = found.as_array().map(Vec::as_slice).unwrap_or_default();
            let found: Vec<&str> = list.iter().filter_map(Value::as_str).collect();
            if found.iter().any(|f| !texts.iter().any(|t| t == f)) {
                Judgment::Wrong
            } else if found.len() < texts.len() {
                Judgment::Unknown
            } else {
                right(found.len() == texts.len())
            }
        }
    }
}

/// Each as often as it occurs.
fn eigenvalues(list: &Value) -> Vec<(f64, f64)> {
    let part = |v: &Value, key: &str| v.get(key).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let times = |v: &Value| v.get("multiplicity").and_then(Value::as_u64).unwrap_or(1) as usize;
    let list = list.as_array().map(Vec::as_slice).unwrap_or_default();
    list.iter().flat_map(|v| vec![(part(v, "re"), part(v, "im")); times(v)]).collect()
}
