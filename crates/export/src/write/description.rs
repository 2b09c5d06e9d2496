//! The comment at the top of a file.

use crate::exported::{Constant, Export, Quantity};

use super::body::index;

/// Lines without the marks of a comment: the model, its quantities with their places, and what a reader has to know.
pub(crate) fn description(made: &Export) -> Vec<String> {
    let arguments = arguments(made);
    let output = if made.outputs.is_empty() { String::new() } else { format!(", y = h({arguments})") };
    let mut lines = vec![
        format!("Model {}: dx/dt = f({arguments}){output}, and their Jacobians.", made.model),
        format!("Written by bracketry {}. Do not edit: change the model and export again.", env!("CARGO_PKG_VERSION")),
    ];
    let place = |array: &str, i: usize| index(made.target.language(), array, i);
    let mut quantities = |title: &str, array: &str, list: &[Quantity]| {
        if list.is_empty() {
            return;
        }
        lines.extend([String::new(), title.to_owned()]);
        lines.extend(list.iter().enumerate().map(|(i, q)| format!("  {} = {}{}", place(array, i), q.name, range(q))));
    };
    quantities("States:", "x", &made.states);
    quantities("Inputs:", "u", &made.inputs);
    quantities("Outputs:", "y", &made.outputs);
    if !made.parameters.is_empty() {
        lines.extend([String::new(), "Parameters, with their values in the model:".to_owned()]);
        let parameters = made.parameters.iter().enumerate();
        lines.extend(parameters.map(|(i, p)| format!("  {} = {}", place("p", i), constant(p))));
    }
    if !made.constants.is_empty() {
        lines.extend([String::new(), "Parameters of the model that are constants here:".to_owned()]);
        lines.extend(made.constants.iter().map(|p| format!("  {}", constant(p))));
    }
    if !made.notes.is_empty() {
        lines.extend([String::new(), "Notes:".to_owned()]);
        lines.extend(made.notes.iter().map(|n| format!("  {n}.")));
    }
    lines.iter().map(|l| plain(l)).collect()
}

/// The arguments of every function.
pub(crate) fn arguments(made: &Export) -> &'static str {
    if made.parameters.is_empty() { "t, x, u" } else { "t, x, u, p" }
}

fn range(q: &Quantity) -> String {
    match (q.min, q.max) {
        (None, None) => String::new(),
        (Some(min), None) => format!(", at least {min}"),
        (None, Some(max)) => format!(", at most {max}"),
        (Some(min), Some(max)) => format!(", from {min} to {max}"),
    }
}

fn constant(p: &Constant) -> String {
    let unit = p.unit.as_ref().filter(|u| *u != "1").map_or_else(String::new, |u| format!(" {u}"));
    let about = p.about.as_ref().map_or_else(String::new, |a| format!(", {a}"));
    format!("{} = {:?}{unit}{about}", p.name, p.value)
}

/// Text of the model that can stand in a comment of any language: nothing that ends it, turns its direction, or begins
/// another one.
fn plain(line: &str) -> String {
    let shown = |c: char| {
        !c.is_control() && !matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let line: String = line.chars().map(|c| if shown(c) { c } else { ' ' }).collect();
    line.replace("*/", "* /").replace("/*", "/ *").trim_end().to_owned()
}

/// A text as a literal between quotes; `$` is a letter like others but in Julia.
pub(crate) fn literal(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out + "\""
}
