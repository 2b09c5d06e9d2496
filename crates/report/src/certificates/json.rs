//! JSON of certificates.

use bracketry_certify::{Certification, Conserved, Finding, Proof};
use bracketry_symbolic::Rational;
use serde_json::{Map, Value, json};

use super::text::reason;

fn proof(p: &Proof) -> Value {
    let mut value = json!({
        "proved": true,
        "conclusion": p.conclusion,
        "function": p.function.to_string(),
        "certificate": p.certificate,
    });
    if let (Some(level), Some(entries)) = (&p.level, value.as_object_mut()) {
        entries.insert("level".into(), json!({"exact": level.to_string(), "value": number(level)}));
    }
    value
}

fn number(q: &Rational) -> f64 {
    q.to_f64().value()
}

fn finding(f: &Finding) -> Value {
    match f {
        Finding::Proved(p) => proof(p),
        Finding::NotProved(why) => {
            let mut value = json!({"proved": false, "reason": why});
            value["reason"]["text"] = Value::String(reason(why));
            value
        }
    }
}

fn conserved(c: &Conserved) -> Value {
    json!({
        "complete_to_degree": c.complete_to,
        "polynomials": c.polynomials.iter().map(proof).collect::<Vec<_>>(),
        "others": c.others.iter().map(ToString::to_string).collect::<Vec<_>>(),
    })
}

/// The findings with their certificates; what was not sought is absent.
pub fn certification_json(found: &Certification) -> Value {
    let point: Map<String, Value> = found
        .point
        .iter()
        .map(|(name, q)| (name.clone(), json!({"exact": q.to_string(), "value": number(q)})))
        .collect();
    let mut out = json!({"model": found.model, "proved": found.is_proved(), "point": point});
    let mut insert = |key: &str, value: Option<Value>| {
        if let (Some(value), Some(entries)) = (value, out.as_object_mut()) {
            entries.insert(key.into(), value);
        }
    };
    let ignored = (!found.ignored_ranges.is_empty()).then(|| json!(found.ignored_ranges));
    insert("ignored_ranges", ignored);
    insert("not_polynomial", found.not_polynomial.as_ref().map(|why| json!(reason(why))));
    let half_planes = |[left, on_axis, right]: [usize; 3]| json!({"left": left, "on_axis": on_axis, "right": right});
    insert("eigenvalues", found.eigenvalues.map(half_planes));
    insert("conserved", found.conserved.as_ref().map(conserved));
    insert("lyapunov", found.lyapunov.as_ref().map(finding));
    insert("region", found.region.as_ref().map(finding));
    insert("passivity", found.passivity.as_ref().map(finding));
    insert("seconds", Some(json!(found.seconds)));
    out
}
