//! The text of verdicts by cases of parameters.

use bracketry_lie::parameters::{
    Aspect, AspectCases, AspectValue, Incomplete, MapCell, ParameterCase, ParameterMap, ParameterReport,
};

/// What an aspect is called.
pub(super) fn name(aspect: Aspect) -> &'static str {
    match aspect {
        Aspect::Accessibility => "accessible dimension",
        Aspect::StrongAccessibility => "strongly accessible dimension",
        Aspect::StaticLinearization => "static feedback linearizable",
        Aspect::RelativeDegree => "relative degrees",
        Aspect::Observability => "rank of the observability codistribution",
        Aspect::LinearControllability => "controllable dimension of the linearization at the point",
        Aspect::LinearObservability => "observable dimension of the linearization at the point",
    }
}

fn value(v: &AspectValue, a: Aspect, states: usize) -> String {
    match (v, a) {
        (AspectValue::Dimension(d), _) => format!("{d} of {states}"),
        _ => v.to_string(),
    }
}

fn case(c: &ParameterCase, a: Aspect, states: usize) -> String {
    let conditions: Vec<String> = c.conditions.iter().map(|f| format!("{f} = 0")).collect();
    let mut line = format!("    {}: {}", conditions.join(" and "), value(&c.value, a, states));
    if c.confirmed_at.is_none() {
        line += "   (for generic values; no rational point found)";
    } else {
        let at: Vec<String> = c.confirmed_at.0.iter().map(|(n, v)| format!("{n} = {v}")).collect();
        line.extend(["   (confirmed at ", &at.join(", "), ")"]);
    }
    if c.within_limits == Some(false) {
        line += "; outside the limits of the parameters";
    }
    line
}

fn open(why: &Incomplete, conditions: usize) -> String {
    match why {
        Incomplete::Function { function } => {
            format!("{function} is not covered by exact minors: zeros and equal parameters were tried one by one")
        }
        Incomplete::TooLarge => "minors, factors, or sets grew too large".to_owned(),
        Incomplete::Nonlinear { condition } => {
            format!(
                "{condition} = 0 was not solved for a parameter by a rational function: the verdict there, or on a \
                 part of it, is open"
            )
        }
        Incomplete::MoreConditions => {
            format!("more than {conditions} simultaneous conditions were not examined (--conditions N)")
        }
        Incomplete::Undecided { reason } => format!("a set of parameters is undecided: {reason}"),
        Incomplete::Time => "time or memory limit reached (--time-limit, --memory-limit)".to_owned(),
    }
}

fn aspect(a: &AspectCases, report: &ParameterReport) -> Vec<String> {
    let generic = match a.generic.known() {
        Some(v) => value(v, a.aspect, report.states),
        None => a.generic.reason().map_or_else(|| "unknown".to_owned(), |r| format!("unknown ({r})")),
    };
    let mut lines = vec![format!("  {}: {generic} for generic parameters", name(a.aspect))];
    lines.extend(a.cases.iter().map(|c| case(c, a.aspect, report.states)));
    if a.complete {
        lines.push(if a.cases.is_empty() {
            "    the same for all parameters at which the equations are defined (proven)".to_owned()
        } else {
            "    these are all the cases (proven)".to_owned()
        });
    } else if a.complete_up_to_conditions {
        let few = match report.conditions {
            1 => "one condition".to_owned(),
            n => format!("{n} simultaneous conditions"),
        };
        lines.push(format!("    these are all the cases with up to {few} (proven)"));
    } else {
        lines.push("    the list of cases may be incomplete".to_owned());
    }
    if !a.complete {
        lines.extend(a.open.iter().map(|why| format!("      {}", open(why, report.conditions))));
    }
    lines
}

/// Verdicts by cases.
pub fn parameter_text(report: &ParameterReport) -> String {
    let mut lines = vec![format!("{}: cases of the parameters {}", report.model, report.parameters.join(", "))];
    if !report.fixed.is_empty() {
        let fixed: Vec<String> = report.fixed.iter().map(|(n, v)| format!("{n} = {v}")).collect();
        lines.push(format!("  at their values: {}", fixed.join(", ")));
    }
    if !report.undefined.is_empty() {
        let list: Vec<String> = report.undefined.iter().map(|f| format!("{f} = 0")).collect();
        lines.push(format!("  the equations are undefined where {}", list.join(" or ")));
    }
    for a in &report.aspects {
        lines.extend(aspect(a, report));
    }
    if let Some(why) = report.no_linearization {
        lines.push(format!("  no statement on the linearization: {why}"));
    }
    if report.certificate.decisions() > 0 {
        lines.push(format!("  probability that a rank is wrong: {}", report.certificate.error_text()));
    }
    lines.join("\n") + "\n"
}

/// What holds in a cell.
pub(super) fn cell(c: &MapCell) -> String {
    match (c.stabilizable, c.unstable, c.on_axis) {
        (_, 0, 0) => "stable".to_owned(),
        (true, 0, _) => "stabilizable linearization, eigenvalues on the axis".to_owned(),
        (true, k, _) => format!("stabilizable linearization, {k} unstable eigenvalue{}", if k == 1 { "" } else { "s" }),
        // An uncontrollable mode of the linearization that does not decay excludes linear feedback alone.
        (false, _, _) => format!("linearization not stabilizable, {} uncontrollable", c.uncontrollable),
    }
}

/// A map in text: how many cells have which verdict, and the exact cases.
pub fn parameter_map_text(map: &ParameterMap) -> String {
    let [a, b] = &map.names;
    let mut lines = vec![format!(
        "{}: {} x {} cells over {a} and {b}; linearization at the center of each",
        map.report.model,
        map.x.len(),
        map.y.len()
    )];
    let mut counts: Vec<(String, usize)> = Vec::new();
    for c in map.cells.iter().flatten() {
        let key = c.as_ref().map_or_else(|| "no rational linearization at an equilibrium".to_owned(), cell);
        match counts.iter_mut().find(|k| k.0 == key) {
            Some(k) => k.1 += 1,
            None => counts.push((key, 1)),
        }
    }
    lines.extend(counts.iter().map(|(key, n)| format!("  {n:>6} {}: {key}", if *n == 1 { "cell" } else { "cells" })));
    lines.join("\n") + "\n" + &parameter_text(&map.report)
}
