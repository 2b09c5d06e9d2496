//! A Julia module.

use std::fmt::Write;

use super::body::body;
use super::description::{arguments, literal};
use super::layout::block;
use super::python::{comment, sentence};
use crate::equations::{Compiled, ExportedResult};
use crate::exported::{Export, SourceFile};
use crate::identifier::camel_case;

/// One file, a module.
pub(crate) fn write(made: &mut Export, functions: &[Compiled]) {
    let module = camel_case(&made.name);
    let mut out = comment(made);
    // Writing to a string does not fail.
    let _ = writeln!(out, "module {module}\n");
    for (what, list) in [("STATES", &made.states), ("INPUTS", &made.inputs), ("OUTPUTS", &made.outputs)] {
        let names: Vec<&str> = list.iter().map(|q| q.name.as_str()).collect();
        let _ = writeln!(out, "const {what} = {}", strings(&names));
    }
    if !made.parameters.is_empty() {
        let names: Vec<&str> = made.parameters.iter().map(|p| p.name.as_str()).collect();
        let values: Vec<String> = made.parameters.iter().map(|p| format!("{:?}", p.value)).collect();
        let _ = writeln!(out, "const PARAMETERS = {}", strings(&names));
        let _ = writeln!(out, "const PARAMETER_VALUES = [{}]", values.join(", "));
    }
    for function in functions {
        out.push_str(&definition(made, function));
    }
    let _ = writeln!(out, "\nend # module {module}");
    made.single.clone_from(&out);
    made.files = vec![SourceFile { name: format!("{module}.jl"), text: out }];
}

fn strings(list: &[&str]) -> String {
    if list.is_empty() {
        return "String[]".to_owned();
    }
    // Julia replaces what follows a dollar sign.
    let literals: Vec<String> = list.iter().map(|n| literal(n).replace('$', "\\$")).collect();
    format!("[{}]", literals.join(", "))
}

fn definition(made: &Export, function: &Compiled) -> String {
    let (body, signature) = (body(made, function), &function.signature);
    let p = if made.parameters.is_empty() { "" } else { ", p = PARAMETER_VALUES" };
    let u = if made.inputs.is_empty() { "u = Float64[]" } else { "u" };
    let about = sentence(signature.about());
    let mut out =
        format!("\n# {}({}): {about}.\nfunction {}(t, x, {u}{p})\n", signature.name, arguments(made), signature.name);
    for line in &body.lines {
        let _ = writeln!(out, "    {line}");
    }
    if let [_] = signature.results[..] {
        let _ = writeln!(out, "    return {}\nend", block(["[", "]"], &body.results[0], "    "));
        return out;
    }
    for (result, entries) in signature.results.iter().zip(&body.results) {
        let _ = writeln!(out, "    {} = {}", result.name, matrix(result, entries));
    }
    let values: Vec<&str> = signature.results.iter().map(|r| r.name).collect();
    let _ = writeln!(out, "    return {}\nend", values.join(", "));
    out
}

/// Matrices are stored column by column.
fn matrix(result: &ExportedResult, entries: &[String]) -> String {
    let (n, m) = (result.rows, result.columns.unwrap_or(1));
    if result.is_empty() {
        return format!("zeros({n}, {m})");
    }
    let column = |j: usize| {
        let entries: Vec<&str> = (0..n).map(|i| entries[i * m + j].as_str()).collect();
        let line = entries.join(", ");
        if line.len() <= 90 { line } else { entries.join(",\n        ") }
    };
    let columns: Vec<String> = (0..m).map(column).collect();
    let size = format!("], {n}, {m})");
    block(["reshape([", &size], &columns, "    ")
}
