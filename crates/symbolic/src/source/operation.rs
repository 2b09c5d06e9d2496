//! One operation as text, with the parentheses that its operands need.

use std::fmt::Write;

use super::language::Language;
use crate::func::{Func, Func2};
use crate::tape::Op;

/// How tightly the outermost operation of a text binds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Level {
    /// `c ? a : b`
    Choice,
    /// `a + b`, `a - b`, `-a`
    Sum,
    /// `a * b`, `a / b`
    Product,
    /// A name, a number, a call, anything in parentheses
    Atom,
}

/// A value as text.
#[derive(Clone, Debug)]
pub(super) struct Term {
    pub(super) text: String,
    pub(super) level: Level,
}

impl Term {
    pub(super) fn atom(text: String) -> Self {
        Term { text, level: Level::Atom }
    }

    /// In parentheses where it binds less tightly.
    fn within(&self, least: Level) -> String {
        if self.level >= least { self.text.clone() } else { format!("({})", self.text) }
    }
}

/// Whether the operation is written with its operands more than once.
pub(super) fn repeats_operands(language: Language, op: Op) -> bool {
    matches!(language, Language::Rust | Language::C | Language::Python)
        && matches!(op, Op::Call(Func::Sign) | Op::Call2(Func2::Min | Func2::Max))
}

/// The shortest decimal that reads back as the same number.
pub(super) fn constant(language: Language, v: f64) -> Term {
    let text = if v.is_finite() {
        format!("{v:?}")
    } else {
        let (nan, infinity) = match language {
            Language::Rust => ("f64::NAN", "f64::INFINITY"),
            Language::C => ("NAN", "INFINITY"),
            Language::Python => ("math.nan", "math.inf"),
            Language::NumPy => ("np.nan", "np.inf"),
            Language::Casadi => ("ca.nan", "ca.inf"),
            Language::Julia => ("NaN", "Inf"),
        };
        let minus = if v < 0.0 { "-" } else { "" };
        if v.is_nan() { nan.to_owned() } else { format!("{minus}{infinity}") }
    };
    let level = if text.starts_with('-') { Level::Sum } else { Level::Atom };
    Term { text, level }
}

/// An operation on operands.
pub(super) fn operation(language: Language, op: Op, a: &Term, b: &Term) -> Term {
    let infix = |sign: &str, level: Level, right: Level| Term {
        text: format!("{} {sign} {}", a.within(level), b.within(right)),
        level,
    };
    match op {
        Op::Add => infix("+", Level::Sum, Level::Product),
        Op::Sub => infix("-", Level::Sum, Level::Product),
        Op::Mul => infix("*", Level::Product, Level::Atom),
        Op::Div => infix("/", Level::Product, Level::Atom),
        Op::Neg => Term { text: format!("-{}", a.within(Level::Atom)), level: Level::Sum },
        Op::Sqrt => call(language, "sqrt", &[a]),
        Op::Pow if language == Language::Julia => {
            Term { text: format!("{} ^ {}", a.within(Level::Atom), b.within(Level::Atom)), level: Level::Product }
        }
        Op::Pow => call(language, "pow", &[a, b]),
        Op::Call(Func::Sign) if repeats_operands(language, op) => {
            let a = &a.text;
            // NaN stays NaN.
            choice(language, &[(format!("{a} > 0.0"), "1.0"), (format!("{a} < 0.0"), "-1.0")], &format!("{a} * 0.0"))
        }
        Op::Call(f) => call(language, f.name(), &[a]),
        Op::Call2(f @ (Func2::Min | Func2::Max)) if repeats_operands(language, op) => {
            let (a, b) = (&a.text, &b.text);
            let (less, or) = (if f == Func2::Min { "<" } else { ">" }, if language.is_python() { "or" } else { "||" });
            choice(language, &[(format!("{a} {less} {b} {or} {a} != {a}"), a)], b)
        }
        Op::Call2(f) => call(language, f.name(), &[a, b]),
    }
}

/// The first value whose condition holds.
fn choice(language: Language, cases: &[(String, &str)], otherwise: &str) -> Term {
    let mut text = String::new();
    for (condition, value) in cases {
        // Writing to a string does not fail.
        let _ = match language {
            Language::Rust => write!(text, "if {condition} {{ {value} }} else "),
            Language::C => write!(text, "{condition} ? {value} : "),
            _ => write!(text, "{value} if {condition} else "),
        };
    }
    let text = if language == Language::Rust { format!("{text}{{ {otherwise} }}") } else { text + otherwise };
    Term { text, level: Level::Choice }
}

fn call(language: Language, function: &str, arguments: &[&Term]) -> Term {
    let name = match (language, function) {
        (Language::Rust, "pow") => "f64::powf".to_owned(),
        (Language::Rust, "log") => "f64::ln".to_owned(),
        (Language::Rust, f) => format!("f64::{f}"),
        (Language::C, "abs") => "fabs".to_owned(),
        (Language::Julia, "atan2") => "atan".to_owned(),
        (Language::C | Language::Julia, f) => f.to_owned(),
        (Language::Python, "abs") => "math.fabs".to_owned(),
        (Language::Python, f) => format!("math.{f}"),
        (Language::NumPy, f) => format!("np.{}", numpy(f)),
        (Language::Casadi, "abs") => "ca.fabs".to_owned(),
        (Language::Casadi, "pow") => "ca.power".to_owned(),
        (Language::Casadi, f @ ("min" | "max")) => format!("ca.f{f}"),
        (Language::Casadi, f) => format!("ca.{f}"),
    };
    let arguments: Vec<&str> = arguments.iter().map(|a| a.text.as_str()).collect();
    Term::atom(format!("{name}({})", arguments.join(", ")))
}

/// What NumPy calls a function.
fn numpy(function: &str) -> &str {
    match function {
        "asin" => "arcsin",
        "acos" => "arccos",
        "atan" => "arctan",
        "atan2" => "arctan2",
        "pow" => "power",
        "min" => "minimum",
        "max" => "maximum",
        f => f,
    }
}
