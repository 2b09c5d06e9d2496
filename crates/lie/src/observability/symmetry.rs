//! Vector fields as differential operators, and the simplest transformations that they generate.

use std::fmt;

use bracketry_symbolic::{Expr, Function, Node, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::as_text::serialized_as_text;

/// A field as a differential operator: its text is such as `-y ∂x + x ∂y + ∂th`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Operator(
    /// The variables along which the field does not vanish, with its components.
    pub Vec<(String, Function)>,
);

impl Operator {
    pub(crate) fn new(pool: &Pool, variables: &[Symbol], field: &[Expr]) -> Self {
        let components = variables.iter().zip(field).filter(|(_, e)| !pool.is_zero(**e));
        Operator(components.map(|(&s, &e)| (pool.name(s).to_owned(), Function::new(pool, e))).collect())
    }
}

impl fmt::Display for Operator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, (name, component)) in self.0.iter().enumerate() {
            let (pool, e) = (component.pool(), component.expr());
            let mut coefficient = match pool.integer(e) {
                Some(1) => String::new(),
                Some(-1) => "-".to_owned(),
                _ => component.text(),
            };
            if matches!(pool.node(e), Node::Add(..)) {
                coefficient = format!("({coefficient})");
            }
            let (sign, size) = match (k, coefficient.strip_prefix('-')) {
                (0, Some(size)) => ("-", size),
                (0, None) => ("", coefficient.as_str()),
                (_, Some(size)) => (" - ", size),
                (_, None) => (" + ", coefficient.as_str()),
            };
            let gap = if size.is_empty() { "" } else { " " };
            write!(f, "{sign}{size}{gap}∂{name}")?;
        }
        Ok(())
    }
}

/// What the flow of a field does, where that has a name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Symmetry {
    /// These variables are moved together.
    Translation {
        /// The variables.
        along: Vec<String>,
    },
    /// Each variable is multiplied by a power of one factor s.
    Scaling {
        /// The variables with their exponents.
        exponents: Vec<(String, Rational)>,
    },
    /// Rotations in planes, with a translation of other variables.
    Rotation {
        /// Pairs of variables.
        planes: Vec<(String, String)>,
        /// Variables that are moved with them.
        along: Vec<String>,
    },
}

impl Symmetry {
    /// What the flow of `field` does, if it is a translation, a scaling or a rotation.
    pub(crate) fn of(pool: &mut Pool, variables: &[Symbol], field: &[Expr]) -> Option<Self> {
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
        let along: Vec<String> = shifted.iter().map(|&i| name(i)).collect();
        if linear.is_empty() {
            return (!along.is_empty()).then_some(Symmetry::Translation { along });
        }
        let diagonal = linear.iter().all(|&i| (0..n).all(|j| i == j || !nonzero(i, j)) && !b[i]);
        if diagonal && along.is_empty() {
            let exponents = linear.iter().map(|&i| (name(i), a[i][i].clone())).collect();
            return Some(Symmetry::Scaling { exponents });
        }
        let mut planes = Vec::new();
        for &i in &linear {
            let mut others = (0..n).filter(|&j| nonzero(i, j));
            let (Some(j), None) = (others.next(), others.next()) else { return None };
            if i == j || a[j][i] != -a[i][j].clone() {
                return None;
            }
            if i < j {
                planes.push((name(i), name(j)));
            }
        }
        Some(Symmetry::Rotation { planes, along })
    }
}

impl fmt::Display for Symmetry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Symmetry::Translation { along } => {
                let together = if along.len() > 1 { " together" } else { "" };
                write!(f, "translation along {}{together}", list(along))
            }
            Symmetry::Scaling { exponents } => {
                let factors: Vec<String> = exponents.iter().map(|(x, k)| format!("{x} by {}", power(k))).collect();
                write!(f, "scaling of {}", list(&factors))
            }
            Symmetry::Rotation { planes, along } => {
                let names: Vec<String> = planes.iter().map(|(x, y)| format!("{x}-{y}")).collect();
                let noun = if planes.len() == 1 { "plane" } else { "planes" };
                write!(f, "rotation in the {} {noun}", list(&names))?;
                if along.is_empty() { Ok(()) } else { write!(f, " together with {}", list(along)) }
            }
        }
    }
}

serialized_as_text!(Operator, Symmetry);

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
        [one, other] => format!("{one} and {other}"),
        [first @ .., last] => format!("{}, and {last}", first.join(", ")),
    }
}
