//! Identifiability in full: text and JSON.

use std::collections::BTreeMap;

use bracketry_lie::observability::{GlobalReason, Identifiability, IdentifiabilityReport};
use serde_json::{Value, json};

fn verdict(v: &Identifiability) -> String {
    match (v.local, v.global, v.values) {
        (Some(true), Some(true), _) => "globally identifiable".to_owned(),
        (Some(true), Some(false), Some(n)) => {
            format!("locally identifiable, not globally: {n} values give the same outputs (including complex ones)")
        }
        (Some(true), ..) => "locally identifiable; global identifiability unknown".to_owned(),
        (Some(false), ..) => "not identifiable".to_owned(),
        (None, ..) => "unknown".to_owned(),
    }
}

fn reason(why: GlobalReason) -> &'static str {
    match why {
        GlobalReason::NotRational => "the equations are not rational",
        GlobalReason::TooLarge => "the polynomial equations are too large",
        GlobalReason::Time => "time or memory limit reached (--time-limit, --memory-limit)",
        GlobalReason::MoreDerivatives => {
            "there are several solutions, but further derivatives may exclude some, because inputs are unknown or \
             initial values are special"
        }
        GlobalReason::Primes => {
            "the computations modulo two primes disagree, or a number does not exist in a prime field"
        }
    }
}

/// The report in text.
pub fn identifiability_text(r: &IdentifiabilityReport) -> String {
    let mut lines = vec![format!("{}: identifiability from the outputs, for generic values", r.model)];
    if !r.known_initial.is_empty() {
        let list = r.known_initial.iter().map(|(s, v)| match v {
            Some(v) => format!("{s}(0) = {v}"),
            None => format!("{s}(0)"),
        });
        lines.push(format!("  known initial values: {}", list.collect::<Vec<_>>().join(", ")));
    }
    if !r.unknown_inputs.is_empty() {
        lines.push(format!("  unknown inputs: {}", r.unknown_inputs.join(", ")));
    }
    let width = r.parameters.iter().chain(&r.states).map(|v| v.name.chars().count() + 3).max().unwrap_or(0);
    lines.extend(r.parameters.iter().map(|v| format!("  {:<width$}  {}", v.name, verdict(v))));
    lines.extend(r.states.iter().map(|v| format!("  {:<width$}  {}", format!("{}(0)", v.name), verdict(v))));
    if let Some(why) = &r.reason {
        lines.push(format!("  local identifiability is unknown: {why}"));
    }
    if let Some(why) = r.global_reason {
        lines.push(format!("  global identifiability is unknown: {}", reason(why)));
    }
    if !r.other_solution.is_empty() {
        let list: Vec<String> = r.other_solution.iter().map(|(name, f)| format!("{f} for {name}")).collect();
        lines.push(format!("  the other solution has {}", list.join(", ")));
    }
    if !r.combinations.is_empty() {
        let list: Vec<String> = r.combinations.iter().map(ToString::to_string).collect();
        lines.push(format!("  locally identifiable combinations of the others: {}", list.join(", ")));
    }
    if let Some(n) = r.combinations_missing.filter(|n| *n > 0) {
        lines.push(format!("  up to {n} further combinations were not found"));
    }
    if r.certificate.decisions() > 0 {
        lines.push(format!("  probability that a local answer is wrong: {}", r.certificate.error_text()));
    }
    lines.join("\n") + "\n"
}

/// The report as an object; what is not known is null.
pub fn identifiability_json(r: &IdentifiabilityReport) -> Value {
    let mut out = json!(r);
    let by_name = |list: &[Identifiability]| -> Value {
        let entry = |v: &Identifiability| json!({"local": v.local, "global": v.global, "values": v.values});
        json!(list.iter().map(|v| (v.name.clone(), entry(v))).collect::<BTreeMap<_, _>>())
    };
    out["parameters"] = by_name(&r.parameters);
    out["states"] = by_name(&r.states);
    out["known_initial"] = json!(r.known_initial.iter().cloned().collect::<BTreeMap<_, _>>());
    let other: BTreeMap<_, _> = r.other_solution.iter().map(|(n, f)| (n.clone(), f.to_string())).collect();
    out["other_solution"] = json!(other);
    if let Some(why) = r.global_reason {
        out["global_reason_text"] = json!(reason(why));
    }
    out
}
