//! From the texts of a report to formulas in LaTeX.

use std::fmt::Write as _;

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

/// A bracket such as `[g1,[f,g2]]`, or a generator; `g2(3)` is g2 in mode 3.
pub(super) fn bracket(name: &str) -> String {
    let mut out = String::new();
    let mut chars = name.chars().peekable();
    let number = |chars: &mut std::iter::Peekable<std::str::Chars<'_>>| {
        let mut digits = String::new();
        while let Some(c) = chars.next_if(char::is_ascii_digit) {
            digits.push(c);
        }
        digits
    };
    while let Some(c) = chars.next() {
        match c {
            '(' => {
                let mode = number(&mut chars);
                chars.next_if_eq(&')');
                let _ = write!(out, "^{{({mode})}}");
            }
            'f' | 'g' => {
                let index = number(&mut chars);
                out.push(c);
                if !index.is_empty() {
                    let _ = write!(out, "_{{{index}}}");
                }
            }
            ',' => out.push_str(", "),
            _ => out.push(c),
        }
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
    // Commas stand between conditions too, but not within a function of two arguments.
    let listed = |p: &str| {
        let mut parts = vec![String::new()];
        let mut depth = 0;
        for c in p.chars() {
            depth += i32::from(c == '(') - i32::from(c == ')');
            match parts.last_mut() {
                Some(last) if c != ',' || depth > 0 => last.push(c),
                _ => parts.push(String::new()),
            }
        }
        parts.iter().map(|p| part(p.trim())).collect::<Vec<_>>().join(",\\ ")
    };
    let join = |list: Vec<String>, word: &str| list.join(&format!("\\ \\text{{{word}}}\\ "));
    let clause = |c: &str| join(c.split(" and ").map(listed).collect(), "and");
    join(text.split(" or ").map(clause).collect(), "or")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_keep_their_words_and_signs() {
        assert_eq!(condition("v = 0"), "v = 0");
        assert_eq!(condition("x1 ≠ 0, cos(y) ≠ 0"), "x_{1} \\ne 0,\\ \\cos\\left(y\\right) \\ne 0");
        assert_eq!(condition("a = 0 or b > 0"), "a = 0\\ \\text{or}\\ b > 0");
    }

    #[test]
    fn brackets_have_indices() {
        assert_eq!(bracket("[g1,[f,g12]]"), "[g_{1}, [f, g_{12}]]");
        assert_eq!(bracket("[f(3)-f(1),g2(4)]"), "[f^{(3)}-f^{(1)}, g_{2}^{(4)}]");
    }

    #[test]
    fn what_is_no_expression_is_set_as_text() {
        assert_eq!(printed("<3 nodes>"), "\\text{<3 nodes>}");
    }
}
