//! From what an analysis found to formulas in LaTeX.

use bracketry_lie::algebra::{Bracket, Generator, Word};
use bracketry_lie::{Condition, Function};
use bracketry_symbolic::{Expr, Notation, Pool};

/// Longer formulas are named by their size: nobody reads them, and they break a page.
const LONGEST: usize = 1500;

/// An expression of a pool.
pub(super) fn expression(pool: &Pool, e: Expr) -> String {
    shortened(pool, e, &pool.notation(e))
}

/// The layout of an expression of a pool.
pub(super) fn shortened(pool: &Pool, e: Expr, notation: &Notation) -> String {
    let formula = notation.latex();
    if formula.len() <= LONGEST {
        formula
    } else {
        format!("\\langle\\text{{{:.0e} nodes}}\\rangle", pool.tree_size(e))
    }
}

/// The name of a state, input or parameter.
pub(super) fn symbol(name: &str) -> String {
    Notation::symbol(name).latex()
}

/// Entries below each other.
pub(super) fn column(entries: &[String]) -> String {
    format!("\\begin{{pmatrix}}{}\\end{{pmatrix}}", entries.join("\\\\ "))
}

/// Numbers with commas between them.
pub(super) fn list(numbers: &[usize]) -> String {
    numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

/// A complex number with four significant digits.
pub(super) fn complex(re: f64, im: f64) -> String {
    let digits = |v: f64| {
        let text = format!("{:.*}", (3 - v.abs().max(1e-12).log10().floor() as i32).clamp(0, 9) as usize, v);
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    };
    if im == 0.0 {
        return digits(re);
    }
    let sign = if im < 0.0 { '-' } else { '+' };
    let real = if re == 0.0 { String::new() } else { format!("{} ", digits(re)) };
    format!("{real}{sign} {}\\,i", digits(im.abs()))
}

/// A function that an analysis found.
pub(super) fn function(f: &Function) -> String {
    expression(f.pool(), f.expr())
}

/// A bracket of generators, such as `[g_{1}, [f, g_{2}]]`; `g_{2}^{(3)}` is g2 in mode 3.
pub(super) fn bracket(b: &Bracket) -> String {
    word(&b.word, &b.generators)
}

fn word(w: &Word, generators: &[Generator]) -> String {
    match w {
        Word::Bracket(ab) => format!("[{}, {}]", word(&ab[0], generators), word(&ab[1], generators)),
        Word::Generator(i) => generators.get(*i).map_or(String::new(), |g| {
            let of_mode = |mode: &Option<usize>| mode.map_or(String::new(), |k| format!("^{{({k})}}"));
            match g {
                Generator::Drift { mode } => format!("f{}", of_mode(mode)),
                Generator::Input { input, mode } => format!("g_{{{input}}}{}", of_mode(mode)),
                Generator::DriftDifference { mode } => format!("f^{{({mode})}}-f^{{(1)}}"),
            }
        }),
    }
}

/// Rows of entries.
pub(super) fn matrix(rows: &[Vec<String>]) -> String {
    let rows: Vec<String> = rows.iter().map(|r| r.join(" & ")).collect();
    format!("\\begin{{pmatrix}}{}\\end{{pmatrix}}", rows.join("\\\\ "))
}

/// A condition on functions.
pub(super) fn condition(c: &Condition) -> String {
    let joined = |list: &[Condition], between: &str| list.iter().map(condition).collect::<Vec<_>>().join(between);
    match c {
        Condition::Vanishes(e) => format!("{} = 0", function(e)),
        Condition::Differs(e) => format!("{} \\ne 0", function(e)),
        Condition::Positive(e) => format!("{} > 0", function(e)),
        Condition::Negative(e) => format!("{} < 0", function(e)),
        Condition::All(list) => joined(list, ",\\ "),
        Condition::Any(list) => joined(list, "\\ \\text{or}\\ "),
    }
}
