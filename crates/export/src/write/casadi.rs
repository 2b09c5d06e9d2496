//! A Python module whose functions return CasADi functions.

use std::fmt::Write;

use super::body::body;
use super::description::arguments;
use super::layout::{block, rows};
use super::python::{comment, names, sentence};
use crate::equations::Compiled;
use crate::exported::{Export, SourceFile};

/// One file, a module.
pub(crate) fn write(made: &mut Export, functions: &[Compiled]) {
    let mut out = comment(made);
    out.push_str("\nimport casadi as ca\n\n");
    out.push_str(&names(made));
    for function in functions {
        out.push_str(&definition(made, function));
    }
    let entries: Vec<String> = functions.iter().map(|f| format!("\"{0}\": {0}()", f.signature.name)).collect();
    // Writing to a string does not fail.
    let _ = write!(
        out,
        "\n\ndef functions():\n    \"\"\"Every function of the model by name.\"\"\"\n    return {{{}}}\n",
        entries.join(", ")
    );
    made.single.clone_from(&out);
    made.files = vec![SourceFile { name: format!("{}_casadi.py", made.name), text: out }];
}

fn definition(made: &Export, function: &Compiled) -> String {
    let (body, signature) = (body(made, function), &function.signature);
    let values: Vec<&str> = signature.results.iter().map(|r| r.name).collect();
    let mut out = format!(
        "\n\ndef {}():\n    \"\"\"{}, the function ({}) -> ({}).\"\"\"\n    t = ca.SX.sym(\"t\")\n",
        signature.name,
        sentence(signature.about()),
        arguments(made),
        values.join(", ")
    );
    let mut sizes = vec![("x", made.states.len()), ("u", made.inputs.len())];
    if !made.parameters.is_empty() {
        sizes.push(("p", made.parameters.len()));
    }
    for (array, size) in sizes {
        // Writing to a string does not fail.
        let _ = writeln!(out, "    {array} = ca.SX.sym(\"{array}\", {size})");
    }
    for line in &body.lines {
        let _ = writeln!(out, "    {line}");
    }
    for (result, entries) in signature.results.iter().zip(&body.results) {
        let value = match result.columns {
            Some(0) => format!("ca.SX({}, 0)", result.rows),
            // Entries that are zero everywhere are none of the sparsity pattern.
            Some(_) => {
                let rows = rows(["ca.horzcat(", ")"], result, entries, "    ");
                block(["ca.sparsify(ca.SX(ca.vertcat(", ")))"], &rows, "    ")
            }
            None => block(["ca.SX(ca.vertcat(", "))"], entries, "    "),
        };
        let _ = writeln!(out, "    {} = {value}", result.name);
    }
    let (arguments, values) = (arguments(made), values.join(", "));
    let quoted = |list: &str| list.split(", ").map(|a| format!("\"{a}\"")).collect::<Vec<_>>().join(", ");
    let _ = writeln!(
        out,
        "    return ca.Function(\"{}\", [{arguments}], [{values}], [{}], [{}])",
        signature.name,
        quoted(arguments),
        quoted(&values)
    );
    out
}
