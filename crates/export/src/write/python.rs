//! A Python module that needs NumPy.

use std::fmt::Write;

use super::body::body;
use super::description::{description, literal};
use super::layout::{block, rows};
use crate::equations::{Compiled, ExportedResult};
use crate::exported::{Export, SourceFile};

/// Reads an argument: a vector of another length is an error, not one of which the first entries count.
const VECTOR: &str = r#"

def _vector(argument, values, length):
    values = np.asarray(values, dtype=float)
    if values.shape[:1] != (length,):
        raise ValueError(f"{argument} has shape {values.shape}, expected ({length},)")
    return values
"#;

/// One file, a module.
pub(crate) fn write(made: &mut Export, functions: &[Compiled]) {
    let mut out = comment(made);
    out.push_str("\nimport numpy as np\n\n");
    out.push_str(&names(made));
    out.push_str(VECTOR);
    for function in functions {
        out.push_str(&definition(made, function));
    }
    made.single.clone_from(&out);
    made.files = vec![SourceFile { name: format!("{}.py", made.name), text: out }];
}

/// The description as comment.
pub(crate) fn comment(made: &Export) -> String {
    description(made).iter().map(|l| if l.is_empty() { "#\n".to_owned() } else { format!("# {l}\n") }).collect()
}

/// The names of all quantities, and the values of the parameters by name.
pub(crate) fn names(made: &Export) -> String {
    let mut out = String::new();
    for (what, list) in [("STATES", &made.states), ("INPUTS", &made.inputs), ("OUTPUTS", &made.outputs)] {
        let literals: Vec<String> = list.iter().map(|q| literal(&q.name)).collect();
        // Writing to a string does not fail.
        let _ = writeln!(out, "{what} = [{}]", literals.join(", "));
    }
    if !made.parameters.is_empty() {
        let entries: Vec<String> =
            made.parameters.iter().map(|p| format!("{}: {:?}", literal(&p.name), p.value)).collect();
        let _ = writeln!(out, "PARAMETERS = {{{}}}", entries.join(", "));
    }
    out
}

fn definition(made: &Export, function: &Compiled) -> String {
    let (body, signature) = (body(made, function), &function.signature);
    let u = if made.inputs.is_empty() { "u=()" } else { "u" };
    let p = if made.parameters.is_empty() { "" } else { ", p=tuple(PARAMETERS.values())" };
    let shapes: Vec<String> = signature.results.iter().map(shape).collect();
    let mut out = format!(
        "\n\ndef {}(t, x, {u}{p}):\n    \"\"\"{}: {}.\"\"\"\n",
        signature.name,
        sentence(signature.about()),
        shapes.join(" and ")
    );
    let mut arguments = vec![("x", made.states.len()), ("u", made.inputs.len())];
    if !made.parameters.is_empty() {
        arguments.push(("p", made.parameters.len()));
    }
    for ((array, length), used) in arguments.into_iter().zip(body.used) {
        let kept = if used { format!("{array} = ") } else { String::new() };
        let _ = writeln!(out, "    {kept}_vector(\"{array}\", {array}, {length})");
    }
    for line in &body.lines {
        let _ = writeln!(out, "    {line}");
    }
    for (result, entries) in signature.results.iter().zip(&body.results) {
        let value = match result.columns {
            Some(0) => format!("np.zeros(({}, 0))", result.rows),
            Some(_) => block(["np.array([", "])"], &rows(["[", "]"], result, entries, "    "), "    "),
            None => block(["np.array([", "])"], entries, "    "),
        };
        let _ = writeln!(out, "    {} = {value}", result.name);
    }
    let values: Vec<&str> = signature.results.iter().map(|r| r.name).collect();
    let _ = writeln!(out, "    return {}", values.join(", "));
    out
}

fn shape(result: &ExportedResult) -> String {
    match result.columns {
        None => format!("{} of shape ({},)", result.name, result.rows),
        Some(m) => format!("{} of shape ({}, {m})", result.name, result.rows),
    }
}

/// With a capital letter.
pub(crate) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
