//! Parameters that have left their tolerance, each by itself.

use bracketry_symbolic::{Named, Notation};
use bracketry_system::System;
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::findings::Findings;
use crate::report::{NamedCause, RefittedParameter, Value};
use crate::settings::DiagnosisSettings;
use crate::{Cause, Formula};

/// Parameters that have left their tolerance: by more than it, as a one-sided test of 5 % says, or out of their range.
pub(super) fn parameter_errors(
    system: &System,
    findings: &Findings,
    parameters: &[RefittedParameter],
    settings: &DiagnosisSettings,
) -> Vec<NamedCause> {
    let unidentified = &findings.chosen.fit.unidentified;
    let student = StudentsT::new(0.0, 1.0, findings.scatter.freedom.max(1.0));
    let tail = |z: f64| student.as_ref().map_or(1.0, |d| d.sf(z));
    parameters
        .iter()
        .enumerate()
        .filter(|(i, _)| !unidentified.contains(i))
        .filter_map(|(_, p)| {
            let moved = (p.after - p.before).abs();
            let known = system.parameters.iter().find(|q| system.symbol_name(q.symbol) == p.name)?;
            let bound = |r: &bracketry_symbolic::Rational| r.to_f64().value();
            let beyond_range = known
                .min
                .as_ref()
                .map_or(0.0, |m| bound(m) - p.after)
                .max(known.max.as_ref().map_or(0.0, |m| p.after - bound(m)));
            let beyond = (moved - settings.tolerance * p.before.abs()).max(beyond_range);
            let std = p.std.max(f64::MIN_POSITIVE);
            if beyond <= 0.0 || tail(beyond / std) > settings.verdict.naming.outside_tolerance {
                return None;
            }
            let p_value = (2.0 * tail(moved / std) * parameters.len() as f64).min(1.0);
            if p_value > settings.significance {
                return None;
            }
            let shown = Value { value: p.after, std: p.std, interval: None, unit: p.unit.clone() };
            let term = moved_to(&p.name, p.after);
            Some(parameter_error(acts_on(system, known.symbol), term, vec![(p.name.clone(), shown)], p_value))
        })
        .collect()
}

/// Parameters with other values than the model's, as the cause.
pub(super) fn parameter_error(
    equation: String,
    term: Formula,
    parameters: Vec<(String, Value)>,
    p_value: f64,
) -> NamedCause {
    NamedCause {
        name: Cause::ParameterError,
        equation,
        term,
        parameters: Named(parameters),
        p_value: Some(p_value),
        confusable_with: Vec::new(),
        separating_experiment: String::new(),
        rivals: Vec::new(),
        share: None,
        flags: Vec::new(),
        combination: None,
    }
}

/// The first state whose equation a parameter stands in.
pub(super) fn acts_on(system: &System, symbol: bracketry_symbolic::Symbol) -> String {
    let place = system.dynamics.iter().position(|e| system.pool.depends_on(*e, symbol));
    place.map(|i| system.symbol_name(system.states[i]).to_owned()).unwrap_or_default()
}

/// A parameter and its new value, with five digits.
pub(super) fn moved_to(name: &str, value: f64) -> Formula {
    let rounded = format!("{value:.4e}").parse::<f64>().unwrap_or(value);
    let notation = Notation::Row(vec![Notation::symbol(name), Notation::Sign('→'), Notation::number(rounded)]);
    Formula::new(format!("{name} -> {rounded}"), notation)
}
