//! What a function does, in statements of the language.

use bracketry_symbolic::{Language, SourceNames};

use crate::equations::Compiled;
use crate::exported::Export;

/// Names in the files that no local may have.
const TAKEN: [&str; 19] = [
    "t",
    "x",
    "u",
    "p",
    "dx",
    "y",
    "f",
    "h",
    "f_x",
    "f_u",
    "h_x",
    "h_u",
    "f_jacobian",
    "h_jacobian",
    "STATES",
    "INPUTS",
    "OUTPUTS",
    "PARAMETERS",
    "_vector",
];

/// The statements of a function.
pub(crate) struct Body {
    /// States, inputs, and parameters that are used, out of x, u, and p; then the locals.
    pub(crate) lines: Vec<String>,
    /// The entries of each result, row by row.
    pub(crate) results: Vec<Vec<String>>,
    /// Whether anything of x, u, p is used.
    pub(crate) used: [bool; 3],
}

/// The statements of a function of the exported model.
pub(crate) fn body(made: &Export, function: &Compiled) -> Body {
    let language = made.target.language();
    let mut names = SourceNames::new(language);
    for taken in TAKEN {
        names.name(taken);
    }
    for size in ["STATES", "INPUTS", "OUTPUTS", "PARAMETERS"] {
        names.name(&format!("{}_{size}", made.name.to_uppercase()));
    }
    let parameters = made.parameters.iter().map(|p| &p.name);
    let arrays: [(&str, Vec<&String>); 3] = [
        ("x", made.states.iter().map(|q| &q.name).collect()),
        ("u", made.inputs.iter().map(|q| &q.name).collect()),
        ("p", parameters.collect()),
    ];
    let mut entries = Vec::new();
    for (k, (array, list)) in arrays.iter().enumerate() {
        entries.extend(list.iter().enumerate().map(|(i, name)| (k, index(language, array, i), names.name(name))));
    }
    let locals: Vec<String> = entries.iter().map(|e| e.2.clone()).collect();
    let statements = function.tape.statements(language, &locals, &names.prefix());
    let mut used = [false; 3];
    let mut lines = Vec::new();
    for ((k, entry, local), _) in entries.iter().zip(&statements.used).filter(|(_, used)| **used) {
        used[*k] = true;
        lines.push(match language {
            Language::C => format!("const double {local} = {entry};"),
            Language::Rust => format!("let {local} = {entry};"),
            _ => format!("{local} = {entry}"),
        });
    }
    lines.extend(statements.lines);
    let mut rest = statements.results.into_iter();
    let results = function.signature.results.iter().map(|r| rest.by_ref().take(r.len()).collect()).collect();
    Body { lines, results, used }
}

/// An entry of an array, counted from 0.
pub(crate) fn index(language: Language, array: &str, i: usize) -> String {
    format!("{array}[{}]", i + usize::from(language == Language::Julia))
}
