//! What feedback can do, as plain text.

use std::fmt::{self, Write as _};

use bracketry_lie::feedback::{
    ControlReport, ExtensionReport, FlatnessReport, FlatnessVerdict, InputOutputReport, LinearizationReport,
    ZeroDynamicsReport,
};
use bracketry_lie::{Answer, Condition, Function, Named};

use super::lists::joined;

/// Longer lines are left to the machine-readable report.
const MAX_LINE: usize = 240;

/// The text, unless it makes no readable line.
fn readable(text: &str) -> String {
    if text.chars().count() <= MAX_LINE { text.to_owned() } else { "(long; see the JSON report)".to_owned() }
}

/// `a = …, b = …`
fn assignments(list: &Named<Function>) -> String {
    list.0.iter().map(|(name, e)| format!("{name} = {e}")).collect::<Vec<_>>().join(", ")
}

/// `z1' = …, z2' = …`
fn rates(list: &[(String, Function)]) -> String {
    list.iter().map(|(name, e)| format!("{name}' = {e}")).collect::<Vec<_>>().join(", ")
}

/// Where one of several conditions fails: `a = 0, b = 0`.
fn away_from(valid: &Condition) -> String {
    match valid.clone().negated() {
        Condition::Any(list) => joined(&list, ", "),
        one => one.to_string(),
    }
}

/// Relative degrees, zero dynamics, linearization and flatness.
pub(super) fn feedback(f: &mut String, r: &ControlReport) -> fmt::Result {
    if let Some(r) = &r.input_output {
        input_output(f, r)?;
    }
    let of_flat_outputs = r.flatness.as_ref().and_then(|r| r.dynamic_extension.as_ref());
    if let Some(r) = &r.dynamic_extension
        && of_flat_outputs != Some(&r.integrators)
    {
        extension(f, r)?;
    }
    if let Some(r) = &r.feedback_linearization {
        linearization(f, r)?;
    }
    if let Some(r) = &r.flatness {
        flatness(f, r)?;
    }
    Ok(())
}

fn input_output(f: &mut String, r: &InputOutputReport) -> fmt::Result {
    writeln!(f, "from inputs to outputs")?;
    let degrees = match &r.relative_degree {
        Answer::Known(d) => d,
        Answer::Unknown(why) => return writeln!(f, "  relative degree        unknown ({why})"),
    };
    for (i, (name, degree)) in r.outputs.iter().zip(degrees).enumerate() {
        let label = if i == 0 { "relative degree" } else { "" };
        match degree {
            Some(r) => writeln!(f, "  {label:<22} {r} of {name}")?,
            None => writeln!(f, "  {label:<22} none for {name}: no input reaches it")?,
        }
    }
    for (i, row) in r.decoupling_matrix.iter().enumerate() {
        let label = if i == 0 { "decoupling matrix" } else { "" };
        writeln!(f, "  {label:<22} {}", readable(&format!("[{}]", joined(row, ", "))))?;
    }
    match (&r.decoupling_determinant, &r.singular_set) {
        (Some(d), Some(set)) => {
            let set = if set.is_nowhere() { "nowhere zero".to_owned() } else { format!("zero where {set}") };
            writeln!(f, "  {:<22} {}", "its determinant", readable(&format!("{d}, {set}")))?;
        }
        (Some(d), None) => writeln!(f, "  {:<22} {}", "its determinant", readable(&d.to_string()))?,
        (None, _) => {}
    }
    if r.vector_relative_degree == Some(false)
        && let Some(rank) = r.decoupling_rank
    {
        writeln!(f, "  {:<22} no: the decoupling matrix has rank {rank}", "vector rel. degree")?;
    }
    if let Some(feedback) = &r.decoupling_feedback {
        for (i, (name, e)) in feedback.0.iter().enumerate() {
            let label = if i == 0 { "decoupling feedback" } else { "" };
            writeln!(f, "  {label:<22} {}", readable(&format!("{name} = {e}")))?;
        }
    }
    match &r.zero_dynamics {
        Some(Answer::Known(z)) => zero_dynamics(f, z),
        Some(Answer::Unknown(why)) => writeln!(f, "  zero dynamics          unknown ({why})"),
        None => Ok(()),
    }
}

fn zero_dynamics(f: &mut String, r: &ZeroDynamicsReport) -> fmt::Result {
    let label = "zero dynamics";
    if r.dimension == 0 {
        return writeln!(f, "  {label:<22} none: holding the outputs leaves no motion");
    }
    let equations: Vec<String> = r.states.iter().zip(&r.equations).map(|(s, e)| format!("{s}' = {e}")).collect();
    writeln!(f, "  {label:<22} {}", readable(&equations.join(", ")))?;
    let mut on = assignments(&r.on);
    if let Some(valid) = &r.valid {
        on = format!("{on}, away from {}", away_from(valid));
    }
    writeln!(f, "  {:<22} {}", "on", readable(&on))?;
    if !r.held_at.0.is_empty() {
        writeln!(f, "  {:<22} {}", "outputs held at", readable(&assignments(&r.held_at)))?;
    }
    if !r.inputs.0.is_empty() {
        writeln!(f, "  {:<22} {}", "held by", readable(&assignments(&r.inputs)))?;
    }
    let why = r.minimum_phase_reason.as_ref().map_or(String::new(), ToString::to_string);
    let verdict = match &r.minimum_phase {
        Answer::Known(true) => "yes",
        Answer::Known(false) => "no",
        Answer::Unknown(_) => "unknown",
    };
    writeln!(f, "  {:<22} {verdict}: {why}", "minimum phase")
}

fn linearization(f: &mut String, r: &LinearizationReport) -> fmt::Result {
    let dims: Vec<String> = r
        .dims
        .iter()
        .enumerate()
        .map(|(i, d)| match r.involutive.get(i) {
            Some(false) => format!("{d} (not involutive)"),
            _ => d.to_string(),
        })
        .collect();
    writeln!(f, "linearization by static feedback")?;
    writeln!(f, "  {:<22} {}", "dimensions of D_i", joined(&dims, ", "))?;
    for (i, (h, list)) in r.linearizing_outputs.iter().zip(&r.coordinates).enumerate() {
        let label = if i == 0 { "linearizing outputs" } else { "" };
        writeln!(f, "  {label:<22} {} (chain of {})", readable(&h.to_string()), list.len())?;
    }
    if let Some(feedback) = &r.feedback {
        writeln!(f, "  {:<22} {}", "linearizing feedback", readable(&assignments(feedback)))?;
    }
    if let Some(set) = r.singular_set.as_ref().filter(|s| !s.is_nowhere()) {
        writeln!(f, "  {:<22} {}", "singular where", readable(&set.to_string()))?;
    }
    if let Some(why) = &r.reason {
        writeln!(f, "  {why}")?;
    }
    Ok(())
}

fn extension(f: &mut String, r: &ExtensionReport) -> fmt::Result {
    writeln!(f, "  {:<22} {}", "dynamic extension", counted(&r.integrators))?;
    writeln!(f, "  {:<22} {}", "", readable(&rates(&r.compensator)))?;
    let (degrees, n) = (sum(&r.relative_degree), r.dimension);
    writeln!(f, "  {:<22} relative degrees {degrees} in dimension {n}", "")
}

fn flatness(f: &mut String, r: &FlatnessReport) -> fmt::Result {
    let verdict = match r.verdict {
        FlatnessVerdict::Yes => "yes",
        FlatnessVerdict::No => "no",
        FlatnessVerdict::Unknown => "unknown",
    };
    writeln!(f, "differentially flat: {verdict}: {}", r.reason)?;
    if !r.flat_outputs.is_empty() {
        writeln!(f, "  {:<22} {}", "flat outputs", readable(&joined(&r.flat_outputs, ", ")))?;
    }
    if let Some(list) = r.dynamic_extension.as_ref().filter(|l| !l.0.is_empty()) {
        writeln!(f, "  {:<22} {}", "with integrators", counted(list))?;
        writeln!(f, "  {:<22} {}", "", readable(&rates(&r.compensator)))?;
        let list: Vec<String> = r.relative_degree.iter().map(ToString::to_string).collect();
        writeln!(f, "  {:<22} {}", "relative degrees", joined(&list, ", "))?;
        if let Some(set) = r.singular_set.as_ref().filter(|s| !s.is_nowhere()) {
            writeln!(f, "  {:<22} {}", "singular where", readable(&set.to_string()))?;
        }
    }
    Ok(())
}

fn counted(list: &Named<usize>) -> String {
    list.0.iter().map(|(name, k)| format!("{k} in front of {name}")).collect::<Vec<_>>().join(", ")
}

fn sum(degrees: &[usize]) -> String {
    degrees.iter().map(ToString::to_string).collect::<Vec<_>>().join(" + ")
}
