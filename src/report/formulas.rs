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

/// A bracket such as `[g1,[f,g2]]`, or a generator.
pub(super) fn bracket(name: &str) -> String {
    let mut out = String::new();
    let mut digits = false;
    for c in name.chars() {
        if c.is_ascii_digit() != digits {
            digits = !digits;
            out.push_str(if digits { "_{" } else { "}" });
        }
        out.push(c);
        if c == ',' {
            out.push(' ');
        }
    }
    if digits {
        out.push('}');
    }
    out
}

/// Rows of entries.
pub(super) fn matrix(rows: &[Vec<String>]) -> String {
    let rows: Vec<String> = rows.iter().map(|r| r.join(" & ")).collect();
    format!("\\begin{{pmatrix}}{}\\end{{pmatrix}}", rows.join("\\\\ "))
}

/// A condition such as `v = 0 or cos(q) = 0`.
pub(super) fn condition(text: &str) -> String {
    let part = |p: &str| {
        for (sign, latex) in
            [(" = ", "="), (" ≠ ", "\\ne"), (" > ", ">"), (" < ", "<"), (" ≥ ", "\\ge"), (" ≤ ", "\\le")]
        {
            if let Some((a, b)) = p.split_once(sign) {
                return format!("{} {latex} {}", printed(a), printed(b));
            }
        }
        printed(p)
    };
    let join = |list: Vec<String>, word: &str| list.join(&format!("\\ \\text{{{word}}}\\ "));
    let clause = |c: &str| join(c.split(" and ").map(part).collect(), "and");
    join(text.split(" or ").map(clause).collect(), "or")
}
