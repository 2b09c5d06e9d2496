//! C99: a header and a source file.

use std::fmt::Write;

use super::body::body;
use super::description::{arguments, description, literal};
use crate::equations::Compiled;
use crate::exported::{Export, SourceFile};

/// The header and the source; as one file, the source follows the header.
pub(crate) fn write(made: &mut Export, functions: &[Compiled]) {
    let header = header(made, functions);
    let source = source(made, functions);
    let name = &made.name;
    made.single = format!("{header}\n#include <math.h>\n{source}");
    let source = format!("/* See {name}.h. */\n#include \"{name}.h\"\n\n#include <math.h>\n{source}");
    made.files = vec![
        SourceFile { name: format!("{name}.h"), text: header },
        SourceFile { name: format!("{name}.c"), text: source },
    ];
}

/// The arrays of names with their length and what a macro calls that; without those that are empty.
fn names(made: &Export) -> Vec<(&'static str, Vec<&str>)> {
    let parameters = made.parameters.iter().map(|p| p.name.as_str()).collect();
    let mut all: Vec<(&'static str, Vec<&str>)> =
        [("state", &made.states), ("input", &made.inputs), ("output", &made.outputs)]
            .map(|(kind, list)| (kind, list.iter().map(|q| q.name.as_str()).collect()))
            .into();
    all.push(("parameter", parameters));
    all.retain(|(_, list)| !list.is_empty());
    all
}

fn header(made: &Export, functions: &[Compiled]) -> String {
    let (name, upper) = (&made.name, made.name.to_uppercase());
    let mut out = String::from("/*\n");
    for line in description(made) {
        let space = if line.is_empty() { "" } else { " " };
        // Writing to a string does not fail.
        let _ = writeln!(out, " *{space}{line}");
    }
    let _ = write!(
        out,
        " *\n * Matrices are stored row by row. No function allocates memory or keeps state; results may overlap with arguments.\n */\n\
         #ifndef {upper}_H\n#define {upper}_H\n\n#ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n"
    );
    let sizes = [
        ("STATES", made.states.len()),
        ("INPUTS", made.inputs.len()),
        ("OUTPUTS", made.outputs.len()),
        ("PARAMETERS", made.parameters.len()),
    ];
    for (what, size) in sizes {
        let _ = writeln!(out, "#define {upper}_{what} {size}");
    }
    out.push('\n');
    for (kind, list) in names(made) {
        let _ = writeln!(out, "extern const char *const {name}_{kind}_names[{}];", list.len());
    }
    if !made.parameters.is_empty() {
        let n = made.parameters.len();
        let _ = writeln!(out, "/* The values of the parameters in the model, for p. */");
        let _ = writeln!(out, "extern const double {name}_parameter_values[{n}];");
    }
    for function in functions {
        let results: Vec<String> = function
            .signature
            .results
            .iter()
            .map(|r| r.columns.map_or(format!("{}[{}]", r.name, r.rows), |m| format!("{}[{} * {m}]", r.name, r.rows)))
            .collect();
        let _ = write!(
            out,
            "\n/* {}({}): {}, {}. */\n{};\n",
            function.signature.name,
            arguments(made),
            function.signature.about(),
            results.join(", "),
            prototype(made, function)
        );
    }
    out.push_str("\n#ifdef __cplusplus\n}\n#endif\n\n#endif\n");
    out
}

fn prototype(made: &Export, function: &Compiled) -> String {
    let p = if made.parameters.is_empty() { "" } else { ", const double *p" };
    let results: Vec<String> = function.signature.results.iter().map(|r| format!("double *{}", r.name)).collect();
    let (name, results) = (function.signature.name, results.join(", "));
    format!("void {}_{name}(double t, const double *x, const double *u{p}, {results})", made.name)
}

fn source(made: &Export, functions: &[Compiled]) -> String {
    let name = &made.name;
    let mut out = String::from("\n");
    for (kind, list) in names(made) {
        let literals: Vec<String> = list.iter().map(|n| literal(n)).collect();
        let _ = writeln!(out, "const char *const {name}_{kind}_names[{}] = {{{}}};", list.len(), literals.join(", "));
    }
    if !made.parameters.is_empty() {
        let values: Vec<String> = made.parameters.iter().map(|p| format!("{:?}", p.value)).collect();
        let n = made.parameters.len();
        let _ = writeln!(out, "const double {name}_parameter_values[{n}] = {{{}}};", values.join(", "));
    }
    for function in functions {
        let body = body(made, function);
        let _ = writeln!(out, "\n{} {{", prototype(made, function));
        out.push_str("    (void)t;\n");
        for (array, used) in ["x", "u", "p"].into_iter().zip(body.used) {
            if !used && (array != "p" || !made.parameters.is_empty()) {
                let _ = writeln!(out, "    (void){array};");
            }
        }
        for line in &body.lines {
            let _ = writeln!(out, "    {line}");
        }
        for (result, entries) in function.signature.results.iter().zip(&body.results) {
            if result.is_empty() {
                let _ = writeln!(out, "    (void){};", result.name);
            }
            for (i, entry) in entries.iter().enumerate() {
                let _ = writeln!(out, "    {}[{i}] = {entry};", result.name);
            }
        }
        out.push_str("}\n");
    }
    out
}
