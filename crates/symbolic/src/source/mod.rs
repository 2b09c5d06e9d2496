//! Compiled expressions as source text, one local per common sub-expression.

mod language;
mod names;
mod operation;
mod statements;

use std::fmt::Write;

pub use self::language::Language;
pub use self::names::SourceNames;
pub use self::statements::Statements;
use crate::node::{Expr, Symbol};
use crate::pool::Pool;
use crate::tape::{CompileError, Tape};

impl Pool {
    /// Source text of a function that computes `outputs` from `arguments`.
    ///
    /// It performs the operations of [`Tape::compile`]: see [`Tape::statements`]. Names that the language does not allow
    /// or has given away are changed: see [`SourceNames`].
    ///
    /// # Errors
    /// [`CompileError::Unbound`] if an expression uses a name that is not an argument.
    ///
    /// ```
    /// use bracketry_symbolic::{Language, Pool};
    /// let mut p = Pool::new();
    /// let e = p.parse("sin(lambda*x)^2 + 1").unwrap();
    /// let arguments = [p.symbol("lambda"), p.symbol("x")];
    /// let text = p.source(Language::Python, "energy", &arguments, &[e]).unwrap();
    /// assert_eq!(text, "\
    /// import math
    ///
    ///
    /// def energy(lambda_, x):
    ///     t0 = math.sin(lambda_ * x)
    ///     return (1.0 + t0 * t0,)
    /// ");
    /// ```
    pub fn source(
        &self,
        language: Language,
        name: &str,
        arguments: &[Symbol],
        outputs: &[Expr],
    ) -> Result<String, CompileError> {
        let tape = Tape::compile(self, arguments, outputs)?;
        let mut names = SourceNames::new(language);
        let name = names.name(name);
        let arguments: Vec<String> = arguments.iter().map(|&s| names.name(self.name(s))).collect();
        let body = tape.statements(language, &arguments, &names.prefix());
        Ok(function(language, &name, &arguments, &body))
    }
}

fn function(language: Language, name: &str, arguments: &[String], body: &Statements) -> String {
    let list = |before: &str, after: &str| -> String {
        arguments.iter().map(|a| format!("{before}{a}{after}")).collect::<Vec<_>>().join(", ")
    };
    let (n, results) = (body.results.len(), body.results.join(", "));
    let mut out = match language {
        Language::Rust => format!(
            "#[allow(clippy::all, non_snake_case, unused_variables, unused_parens)]\npub fn {name}({}) -> [f64; {n}] {{\n",
            list("", ": f64")
        ),
        Language::C => {
            let mut arguments = list("double ", "");
            if !arguments.is_empty() {
                arguments.push_str(", ");
            }
            // An array has at least one element in C.
            format!("#include <math.h>\n\nvoid {name}({arguments}double out[{}]) {{\n", n.max(1))
        }
        Language::Python => format!("import math\n\n\ndef {name}({}):\n", list("", "")),
        Language::NumPy => format!("import numpy as np\n\n\ndef {name}({}):\n", list("", "")),
        Language::Casadi => format!("import casadi as ca\n\n\ndef {name}({}):\n", list("", "")),
        Language::Julia => format!("function {name}({})\n", list("", "")),
    };
    for line in &body.lines {
        out.push_str("    ");
        out.push_str(line);
        out.push('\n');
    }
    let comma = if n == 1 { "," } else { "" };
    // Writing to a string does not fail.
    let _ = match language {
        Language::Rust => writeln!(out, "    [{results}]\n}}"),
        Language::C => {
            for (i, r) in body.results.iter().enumerate() {
                let _ = writeln!(out, "    out[{i}] = {r};");
            }
            writeln!(out, "}}")
        }
        Language::Julia => writeln!(out, "    return ({results}{comma})\nend"),
        Language::Python | Language::NumPy | Language::Casadi => writeln!(out, "    return ({results}{comma})"),
    };
    out
}
