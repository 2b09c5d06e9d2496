//! Vector fields as text, and the names of the simplest transformations that they generate.

use bracketry_symbolic::{Expr, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

/// A field as a differential operator: `-y ∂x + x ∂y + ∂th`.
pub(crate) fn operator_text(pool: &Pool, variables: &[Symbol], field: &[Expr]) -> String {
    let mut text = String::new();
    for (&s, &e) in variables.iter().zip(field) {
        if pool.is_zero(e) {
            continue;
        }
        let mut coefficient = match pool.integer(e) {
            Some(1) => String::new(),
            Some(-1) => "-".to_owned(),
            _ => pool.text(e),
        };
        if matches!(pool.node(e), bracketry_symbolic::Node::Add(..)) {
            coefficient = format!("({coefficient})");
        }
        let negative = coefficient.strip_prefix('-').map(str::to_owned);
        let sign = match (text.is_empty(), negative.is_some()) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        };
        let rest = negative.unwrap_or(coefficient);
        let gap = if rest.is_empty() { "" } else { " " };
        text.extend([sign, &rest, gap, "∂", pool.name(s)]);
    }
    text
}

/// What the flow of a field does, in words, if it is a translation, a scaling or a rotation.
pub(crate) fn symmetry_name(pool: &mut Pool, variables: &[Symbol], field: &[Expr]) -> Option<String> {
    let n = variables.len();
    let origin: FxHashMap<Expr, Expr> = {
        let zero = pool.int(0);
        variables.iter().map(|&s| (pool.sym(s), zero)).collect()
    };
    // The field is A x + b, with numbers in A.
    let mut a: Vec<Vec<Rational>> = Vec::with_capacity(n);
    let mut b: Vec<bool> = Vec::with_capacity(n);
    for &e in field {
        let mut row = Vec::with_capacity(n);
        for &s in variables {
            let d = pool.diff(e, s);
            let d = pool.simplify(d);
            row.push(pool.number(d)?.clone());
        }
        a.push(row);
        let rest = pool.substitute(e, &origin);
        let rest = pool.simplify(rest);
        b.push(!pool.is_zero(rest));
    }
    let name = |i: usize| pool.name(variables[i]).to_owned();
    let nonzero = |i: usize, j: usize| a[i][j] != Rational::ZERO;
    let linear: Vec<usize> = (0..n).filter(|&i| (0..n).any(|j| nonzero(i, j))).collect();
    let shifted: Vec<usize> = (0..n).filter(|&i| b[i] && !linear.contains(&i)).collect();
    if linear.is_empty() {
        let along: Vec<String> = shifted.iter().map(|&i| name(i)).collect();
        return match along.len() {
            0 => None,
            1 => Some(format!("translation along {}", along[0])),
            _ => Some(format!("translation along {} together", list(&along))),
        };
    }
    let diagonal = linear.iter().all(|&i| (0..n).all(|j| i == j || !nonzero(i, j)) && !b[i]);
    if diagonal && shifted.is_empty() {
        let factors: Vec<String> = linear.iter().map(|&i| format!("{} by {}", name(i), power(&a[i][i]))).collect();
        return Some(format!("scaling of {}", list(&factors)));
    }
    let mut planes = Vec::new();
    for &i in &linear {
        let mut others = (0..n).filter(|&j| nonzero(i, j));
        let (Some(j), None) = (others.next(), others.next()) else { return None };
        if i == j || a[j][i] != -a[i][j].clone() {
            return None;
        }
        if i < j {
            planes.push(format!("{}-{}", name(i), name(j)));
        }
    }
    let noun = if planes.len() == 1 { "plane" } else { "planes" };
    let mut text = format!("rotation in the {} {noun}", list(&planes));
    if !shifted.is_empty() {
        let with: Vec<String> = shifted.iter().map(|&i| name(i)).collect();
        text.extend([" together with ", &list(&with)]);
    }
    Some(text)
}

fn power(exponent: &Rational) -> String {
    if *exponent == Rational::ONE { "s".to_owned() } else { format!("s^{}", in_brackets(exponent)) }
}

fn in_brackets(exponent: &Rational) -> String {
    if exponent.is_int() && *exponent > Rational::ZERO { exponent.to_string() } else { format!("({exponent})") }
}

/// `a`, `a and b`, `a, b and c`
fn list(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
