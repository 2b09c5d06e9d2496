//! From the texts of a report to formulas in LaTeX.

use bracketry_symbolic::{Expr, Pool};

/// Longer formulas are named by their size: nobody reads them, and they break a page.
const LONGEST: usize = 1500;

/// An expression of a pool.
pub(super) fn expression(pool: &Pool, e: Expr) -> String {
    let formula = pool.latex(e);
    if formula.len() <= LONGEST {
        formula
    } else {
        format!("\\langle\\text{{{:.0e} nodes}}\\rangle", pool.tree_size(e))
    }
}

/// A text that an analysis printed.
pub(super) fn printed(text: &str) -> String {
    let mut pool = Pool::new();
    match pool.parse(text) {
        Ok(e) => expression(&pool, e),
        Err(_) => format!("\\text{{{}}}", text.replace(['$', '\\', '{', '}', '_', '^', '%', '#', '&', '~'], " ")),
    }
}

/// The name of a state, input or parameter.
pub(super) fn symbol(name: &str) -> String {
    let mut pool = Pool::new();
    let e = pool.var(name);
    pool.latex(e)
}

/// Entries below each other.
pub(super) fn column(entries: &[String]) -> String {
    format!("\\begin{{pmatrix}}{}\\end{{pmatrix}}", entries.join("\\\\ "))
}

/// Numbers with commas between them.
pub(super) fn list(numbers: &[usize]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}
