//! f, h and their Jacobians as tapes.

use bracketry_symbolic::{Expr, Pool, Symbol, Tape};
use serde::Serialize;

use crate::error::ExportError;

/// An array that an exported function computes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExportedResult {
    /// Its name, such as `f_x` for ∂f/∂x.
    pub name: &'static str,
    /// Number of rows.
    pub rows: usize,
    /// Number of columns of a matrix; none of a vector.
    pub columns: Option<usize>,
}

impl ExportedResult {
    fn vector(name: &'static str, rows: usize) -> Self {
        Self { name, rows, columns: None }
    }

    fn matrix(name: &'static str, rows: usize, columns: usize) -> Self {
        Self { name, rows, columns: Some(columns) }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.rows * self.columns.unwrap_or(1)
    }

    /// Whether there are no entries, as in ∂f/∂u of a model without inputs.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A function of an exported model.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExportedFunction {
    /// `f`, `h`, `f_jacobian`, or `h_jacobian`.
    pub name: &'static str,
    /// What it computes, in order.
    pub results: Vec<ExportedResult>,
    /// Number of arithmetic operations and calls of elementary functions.
    pub operations: usize,
}

impl ExportedFunction {
    /// What it computes, in words.
    pub fn about(&self) -> &'static str {
        match self.name {
            "f" => "time derivatives of the states",
            "h" => "outputs",
            "f_jacobian" => "derivatives of f with respect to x and u",
            _ => "derivatives of h with respect to x and u",
        }
    }
}

/// A function with its instructions; the entries of matrices follow each other row by row.
pub(crate) struct Compiled {
    pub(crate) signature: ExportedFunction,
    pub(crate) tape: Tape,
}

/// Compiles f and h with their Jacobians; h is left out where there are no outputs.
pub(crate) fn compiled(
    pool: &mut Pool,
    [states, inputs, kept]: [&[Symbol]; 3],
    dynamics: &[Expr],
    outputs: &[Expr],
) -> Result<Vec<Compiled>, ExportError> {
    let arguments = [states, inputs, kept].concat();
    let mut all = Vec::new();
    let rows = [("f", "f_jacobian", ["dx", "f_x", "f_u"], dynamics), ("h", "h_jacobian", ["y", "h_x", "h_u"], outputs)];
    for (name, _, [value, ..], rows) in rows.iter().filter(|r| !r.3.is_empty()) {
        let tape = Tape::compile(pool, &arguments, rows)?;
        all.push(new(name, vec![ExportedResult::vector(value, rows.len())], tape));
    }
    for (_, name, [_, by_state, by_input], rows) in rows.iter().filter(|r| !r.3.is_empty()) {
        let mut entries = pool.jacobian(rows, states).concat();
        entries.extend(pool.jacobian(rows, inputs).concat());
        let tape = Tape::compile(pool, &arguments, &entries)?;
        let results = vec![
            ExportedResult::matrix(by_state, rows.len(), states.len()),
            ExportedResult::matrix(by_input, rows.len(), inputs.len()),
        ];
        all.push(new(name, results, tape));
    }
    Ok(all)
}

fn new(name: &'static str, results: Vec<ExportedResult>, tape: Tape) -> Compiled {
    Compiled { signature: ExportedFunction { name, results, operations: tape.code().len() }, tape }
}
