//! A Rust module.

use std::fmt::Write;

use super::body::body;
use super::description::{description, literal};
use super::layout::{block, rows};
use crate::equations::{Compiled, ExportedResult};
use crate::exported::{Export, SourceFile};

/// One file, a module.
pub(crate) fn write(made: &mut Export, functions: &[Compiled]) {
    let mut out = String::from("//! ```text\n");
    for line in description(made) {
        let space = if line.is_empty() { "" } else { " " };
        // Writing to a string does not fail.
        let _ = writeln!(out, "//!{space}{}", line.replace("```", "'''"));
    }
    out.push_str(
        "//! ```\n//!\n//! No function allocates. Without the standard library, provide the functions of `f64` by a trait, such as `use num_traits::Float;`\n\
         //! (feature `libm`).\n\
         #![allow(unused_variables, unused_parens, dead_code, non_snake_case, clippy::all)]\n\n",
    );
    let parameters: Vec<&str> = made.parameters.iter().map(|p| p.name.as_str()).collect();
    for (what, of, list) in [
        ("STATES", "states, in the order of `x`", made.states.iter().map(|q| q.name.as_str()).collect()),
        ("INPUTS", "inputs, in the order of `u`", made.inputs.iter().map(|q| q.name.as_str()).collect()),
        ("OUTPUTS", "outputs, in the order of `y`", made.outputs.iter().map(|q| q.name.as_str()).collect()),
        ("PARAMETERS", "parameters, in the order of `p`", parameters),
    ] {
        if list.is_empty() {
            continue;
        }
        let literals: Vec<String> = list.iter().map(|n| literal(n)).collect();
        let _ = writeln!(out, "/// Names of the {of}.");
        let _ = writeln!(out, "pub const {what}: [&str; {}] = [{}];", list.len(), literals.join(", "));
    }
    if !made.parameters.is_empty() {
        let values: Vec<String> = made.parameters.iter().map(|p| format!("{:?}", p.value)).collect();
        let _ = writeln!(out, "/// Values of the parameters in the model.");
        let _ = writeln!(out, "pub const PARAMETER_VALUES: [f64; {}] = [{}];", values.len(), values.join(", "));
    }
    for function in functions {
        out.push_str(&item(made, function));
    }
    made.single.clone_from(&out);
    made.files = vec![SourceFile { name: format!("{}.rs", made.name), text: out }];
}

fn kind(result: &ExportedResult) -> String {
    match result.columns {
        None => format!("[f64; {}]", result.rows),
        Some(m) => format!("[[f64; {m}]; {}]", result.rows),
    }
}

fn item(made: &Export, function: &Compiled) -> String {
    let (body, signature) = (body(made, function), &function.signature);
    let names: Vec<&str> = signature.results.iter().map(|r| r.name).collect();
    let kinds: Vec<String> = signature.results.iter().map(kind).collect();
    let (names, kinds) = match &signature.results[..] {
        [_] => (names.concat(), kinds.concat()),
        _ => (format!("({})", names.join(", ")), format!("({})", kinds.join(", "))),
    };
    let (n, m) = (made.states.len(), made.inputs.len());
    let p = if made.parameters.is_empty() { String::new() } else { format!(", p: &[f64; {}]", made.parameters.len()) };
    let about = signature.about();
    let mut out = format!(
        "\n/// `{names}`: {about}.\npub fn {}(t: f64, x: &[f64; {n}], u: &[f64; {m}]{p}) -> {kinds} {{\n",
        signature.name
    );
    for line in &body.lines {
        let _ = writeln!(out, "    {line}");
    }
    for (result, entries) in signature.results.iter().zip(&body.results) {
        let value = match result.columns {
            None => block(["[", "]"], entries, "    "),
            Some(_) => block(["[", "]"], &rows(["[", "]"], result, entries, "    "), "    "),
        };
        let _ = writeln!(out, "    let {}: {} = {value};", result.name, kind(result));
    }
    let _ = writeln!(out, "    {names}\n}}");
    out
}
