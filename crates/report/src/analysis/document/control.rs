//! Sections on what the inputs do to the outputs and on linearization by feedback.

use bracketry_lie::controllability::Subject;
use bracketry_lie::feedback::{
    FlatnessReport, FlatnessVerdict, InputOutputReport, LinearizationReport, ZeroDynamicsReport,
};
use bracketry_lie::{Answer, Condition, Function};

use super::blocks::{Block, Line, item, math, section, text, words};
use super::formulas::{complex, condition, function, list, matrix, symbol};
use crate::analysis::text::yes_no;
use bracketry_lie::Analysis;

/// Relative degrees, decoupling matrix, zero dynamics.
pub(super) fn input_output(a: &Analysis, out: &mut Vec<Block>) {
    let Some(io) = &a.report.control.input_output else { return };
    section(out, "From inputs to outputs");
    let degrees = match &io.relative_degree {
        Answer::Unknown(why) => {
            out.push(words(format!("The relative degree is unknown: {why}.")));
            return;
        }
        Answer::Known(degrees) => degrees,
    };
    let row = |(name, degree): (&String, &Option<usize>)| {
        let degree = degree.map_or_else(|| vec![text("no input reaches it")], |r| vec![math(r.to_string())]);
        vec![vec![math(symbol(name))], degree]
    };
    let header = ["output", "relative degree"].map(|h| vec![text(h)]).to_vec();
    out.push(Block::Table(header, io.outputs.iter().zip(degrees).map(row).collect()));
    decoupling(io, degrees, out);
    match &io.zero_dynamics {
        Some(Answer::Known(z)) => zero_dynamics(z, out),
        Some(Answer::Unknown(why)) => out.push(words(format!("Zero dynamics: unknown ({why})."))),
        None => {
            if let Some(why) = &io.zero_dynamics_reason {
                out.push(words(format!("Zero dynamics: none ({why}).")));
            }
        }
    }
}

fn decoupling(io: &InputOutputReport, degrees: &[Option<usize>], out: &mut Vec<Block>) {
    if io.decoupling_matrix.is_empty() {
        return;
    }
    let rows: Vec<Vec<String>> = io.decoupling_matrix.iter().map(|r| r.iter().map(function).collect()).collect();
    let derivatives: Vec<String> = io
        .outputs
        .iter()
        .zip(degrees)
        .map(|(name, r)| r.map_or_else(|| "0".to_owned(), |r| format!("{{{}}}^{{({r})}}", symbol(name))))
        .collect();
    let mut formulas = vec![format!("{} &= b(x) + A(x)\\,u", super::formulas::column(&derivatives))];
    formulas.push(format!("A &= {}", matrix(&rows)));
    if let Some(d) = &io.decoupling_determinant {
        formulas.push(format!("\\det A &= {}", function(d)));
    }
    out.push(words("Highest output derivatives, with the decoupling matrix A:"));
    out.push(Block::Display(formulas));
    let mut items = Vec::new();
    if let Some(rank) = io.decoupling_rank {
        let full = match io.vector_relative_degree {
            Some(true) => ": the outputs have a vector relative degree",
            Some(false) => ": not full row rank, so static feedback does not decouple the outputs",
            None => "",
        };
        items.push(vec![text(format!("generic rank of A: {rank}{full}"))]);
    }
    if let Some(set) = &io.singular_set {
        items.push(singular(set, "A is singular where ", "A is nowhere singular"));
    }
    if let Some(feedback) = &io.decoupling_feedback {
        items.push(feedback_line("feedback that decouples the outputs: ", &feedback.0));
    }
    if !items.is_empty() {
        out.push(Block::List(items));
    }
}

/// `words` with the set, or what is said where it is empty.
fn singular(set: &Condition, words: &str, nowhere: &str) -> Line {
    if set.is_nowhere() { vec![text(nowhere)] } else { vec![text(words), math(condition(set))] }
}

fn feedback_line(words: &str, feedback: &[(String, Function)]) -> Line {
    let formulas: Vec<String> = feedback.iter().map(|(u, e)| format!("{} = {}", symbol(u), function(e))).collect();
    vec![text(words), math(formulas.join(",\\quad "))]
}

fn zero_dynamics(z: &ZeroDynamicsReport, out: &mut Vec<Block>) {
    let held = if z.held_at.0.is_empty() { "at zero".to_owned() } else { "at the values of the point".to_owned() };
    if z.dimension == 0 {
        out.push(words(format!("No zero dynamics: holding the outputs {held} determines the state.")));
    } else {
        out.push(words(format!("Zero dynamics, of dimension {}, while the outputs are held {held}:", z.dimension)));
        let rates = z.states.iter().zip(&z.equations);
        out.push(Block::Display(rates.map(|(s, e)| format!("\\dot{{{}}} &= {}", symbol(s), function(e))).collect()));
    }
    let mut items = Vec::new();
    if !z.on.0.is_empty() {
        items.push(feedback_line("on the set ", &z.on.0));
    }
    if !z.inputs.0.is_empty() {
        items.push(feedback_line("held by ", &z.inputs.0));
    }
    if let Some(valid) = &z.valid {
        items.push(vec![text("where "), math(condition(valid))]);
    }
    if !z.eigenvalues.is_empty() {
        let list: Vec<String> = z.eigenvalues.iter().map(|e| complex(e.re, e.im)).collect();
        items.push(vec![text("eigenvalues at the equilibrium: "), math(list.join(",\\ "))]);
    }
    if z.dimension > 0 {
        let why = z.minimum_phase_reason.as_ref().filter(|_| z.minimum_phase.known().is_some());
        let why = why.map_or(String::new(), |w| format!(" ({w})"));
        items.push(item("minimum phase", format!("{}{why}", yes_no(&z.minimum_phase))));
    }
    if !items.is_empty() {
        out.push(Block::List(items));
    }
}

/// Linearization by static feedback.
pub(super) fn linearization(a: &Analysis, out: &mut Vec<Block>) {
    if a.inputs == 0 {
        return;
    }
    section(out, "Feedback linearization");
    let report = &a.report;
    if report.global_statements_of == Some(Subject::Smoothed) {
        out.push(words("Statements of the smoothed model."));
    }
    let mut items = vec![
        item("input fields span an involutive distribution", yes_no(&report.involutive)),
        item(
            "linearizable by static state feedback near a generic point",
            yes_no(&report.static_feedback_linearizable),
        ),
    ];
    if let Some(l) = &report.control.feedback_linearization {
        flag(l, &mut items);
    }
    out.push(Block::List(items));
    if let Some(l) = &report.control.feedback_linearization {
        linear_form(l, out);
    }
    if let Some(e) = &report.control.dynamic_extension {
        let integrators: Vec<String> =
            e.integrators.0.iter().map(|(u, k)| format!("{k}\\text{{ in front of }}{}", symbol(u))).collect();
        let flat = if e.linearizes { "; the outputs are flat" } else { "" };
        out.push(Block::Paragraph(vec![
            text("Dynamic extension: with integrators ("),
            math(integrators.join(",\\ ")),
            text(") the outputs have the relative degrees "),
            math(list(&e.relative_degree)),
            text(format!(" in a state of dimension {}{flat}.", e.dimension)),
        ]));
    }
    if let Some(f) = &report.control.flatness {
        flatness(f, out);
    }
}

fn flatness(f: &FlatnessReport, out: &mut Vec<Block>) {
    let verdict = match f.verdict {
        FlatnessVerdict::Yes => "yes",
        FlatnessVerdict::No => "no",
        FlatnessVerdict::Unknown => "unknown",
    };
    let mut items = vec![item("differentially flat", format!("{verdict} ({})", f.reason))];
    if !f.flat_outputs.is_empty() {
        let outputs: Vec<String> = f.flat_outputs.iter().map(function).collect();
        items.push(vec![text("flat outputs: "), math(outputs.join(",\\ "))]);
    }
    if let Some(extension) = f.dynamic_extension.as_ref().filter(|e| !e.is_empty()) {
        let inputs: Vec<String> = extension.0.iter().map(|(u, k)| format!("{u} ({k})")).collect();
        items.push(vec![
            text(format!(
                "linearized with integrators in front of {}, which gives the relative degrees ",
                inputs.join(", ")
            )),
            math(list(&f.relative_degree)),
        ]);
    }
    if let Some(set) = &f.singular_set {
        items.push(singular(set, "singular where ", "nowhere singular"));
    }
    out.push(Block::List(items));
}

fn flag(l: &LinearizationReport, items: &mut Vec<Line>) {
    items.push(vec![
        text("dimensions of "),
        math("D_i = \\operatorname{span}\\{\\mathrm{ad}_f^k g_j : k \\le i\\}"),
        text(": "),
        math(list(&l.dims)),
    ]);
    if let Some(i) = l.involutive.iter().position(|v| !v) {
        items.push(vec![math(format!("D_{{{i}}}")), text(" is not involutive")]);
    }
    if !l.controllability_indices.is_empty() {
        items.push(vec![text("lengths of the chains of integrators: "), math(list(&l.controllability_indices))]);
    }
    if let Some(why) = &l.reason {
        items.push(vec![text(why.to_string())]);
    }
}

fn linear_form(l: &LinearizationReport, out: &mut Vec<Block>) {
    if l.linearizing_outputs.is_empty() {
        return;
    }
    out.push(words("Linearizing outputs with their derivatives, the coordinates in which the system is linear:"));
    let rows = l.coordinates.iter().enumerate().flat_map(|(k, chain)| {
        chain.iter().enumerate().map(move |(j, e)| {
            let dots = if j == 0 { String::new() } else { format!("^{{({j})}}") };
            format!("y_{{{}}}{dots} &= {}", k + 1, function(e))
        })
    });
    out.push(Block::Display(rows.collect()));
    let mut items = Vec::new();
    if let Some(feedback) = &l.feedback {
        items.push(feedback_line("linearizing feedback: ", &feedback.0));
    }
    if let Some(set) = &l.singular_set {
        items.push(singular(set, "not defined where ", "defined everywhere"));
    }
    if !items.is_empty() {
        out.push(Block::List(items));
    }
}
