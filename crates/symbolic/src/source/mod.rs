//! Compiled expressions as source text: Rust, C and Python functions, one local per common sub-expression.

mod names;

use std::fmt::Write;

use self::names::Scope;
use crate::func::{Func, Func2};
use crate::pool::{Expr, Pool, Symbol};
use crate::tape::{CompileError, Op, Tape};

/// A language in which [`Pool::source`] writes.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Language {
    /// `pub fn name(x: f64, …) -> [f64; n]`, which needs only the standard library.
    Rust,
    /// `void name(double x, …, double out[n])`, C99 with `math.h`.
    C,
    /// `def name(x, …)`, which returns a tuple and needs the module `math`.
    ///
    /// Python raises `ZeroDivisionError`, `ValueError` or `OverflowError` where the other languages give an infinity
    /// or NaN.
    Python,
}

impl Pool {
    /// Source text of a function that computes `outputs` from `arguments`.
    ///
    /// It performs the operations of [`Tape::compile`] in the same order, each assigned to a local once: common
    /// sub-expressions are computed once, small integer powers are products, `sign`, `abs`, `min` and `max` treat
    /// NaN as the tape does. Names that the language does not allow or has given away are changed: letters beyond
    /// ASCII become their code, anything else that is no letter or digit becomes `_`, and what is reserved gets a
    /// `_` at its end.
    ///
    /// # Errors
    /// [`CompileError::Unbound`] if an expression uses a name that is not an argument.
    ///
    /// ```
    /// use bracketry_symbolic::{Language, Pool};
    /// let mut p = Pool::new();
    /// let e = p.parse("lambda*x^2").unwrap();
    /// let arguments = [p.symbol("lambda"), p.symbol("x")];
    /// let text = p.source(Language::Python, "energy", &arguments, &[e]).unwrap();
    /// assert_eq!(text, "\
    /// import math
    ///
    ///
    /// def energy(lambda_, x):
    ///     t0 = x * x
    ///     t1 = lambda_ * t0
    ///     return (t1,)
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
        let mut scope = Scope::new(language);
        let name = scope.name(name);
        let arguments: Vec<String> = arguments.iter().map(|&s| scope.name(self.name(s))).collect();
        let prefix = scope.prefix();
        let writer = Writer { language, tape: &tape, arguments: &arguments, prefix: &prefix };
        Ok(writer.function(&name))
    }
}

struct Writer<'a> {
    language: Language,
    tape: &'a Tape,
    arguments: &'a [String],
    prefix: &'a str,
}

impl Writer<'_> {
    fn function(&self, name: &str) -> String {
        let (n, tape) = (self.tape.n_outputs(), self.tape);
        let list = |before: &str, after: &str| -> String {
            self.arguments.iter().map(|a| format!("{before}{a}{after}")).collect::<Vec<_>>().join(", ")
        };
        let mut out = match self.language {
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
        };
        for (i, c) in tape.code().iter().enumerate() {
            let (a, b) = (self.operand(c.a), self.operand(c.b));
            let value = self.operation(c.op, &a, &b);
            // Writing to a string does not fail.
            let _ = match self.language {
                Language::Rust => writeln!(out, "    let {}{i} = {value};", self.prefix),
                Language::C => writeln!(out, "    const double {}{i} = {value};", self.prefix),
                Language::Python => writeln!(out, "    {}{i} = {value}", self.prefix),
            };
        }
        let results: Vec<String> = tape.outputs().iter().map(|&r| self.operand(r)).collect();
        match self.language {
            Language::Rust => {
                let _ = writeln!(out, "    [{}]\n}}", results.join(", "));
            }
            Language::C => {
                for (i, r) in results.iter().enumerate() {
                    let _ = writeln!(out, "    out[{i}] = {r};");
                }
                out.push_str("}\n");
            }
            Language::Python => {
                let comma = if n == 1 { "," } else { "" };
                let _ = writeln!(out, "    return ({}{comma})", results.join(", "));
            }
        }
        out
    }

    /// An argument, a constant or a local.
    fn operand(&self, register: u32) -> String {
        let r = register as usize;
        let first = self.tape.n_inputs() + self.tape.constants().len();
        if r < self.tape.n_inputs() {
            self.arguments[r].clone()
        } else if r < first {
            self.constant(self.tape.constants()[r - self.tape.n_inputs()])
        } else {
            format!("{}{}", self.prefix, r - first)
        }
    }

    /// The shortest decimal that reads back as the same number.
    fn constant(&self, v: f64) -> String {
        let s = match (self.language, v.is_finite()) {
            (Language::Rust, true) => format!("{v:?}_f64"),
            (_, true) => format!("{v:?}"),
            (Language::Rust, false) if v.is_nan() => "f64::NAN".to_owned(),
            (Language::C, false) if v.is_nan() => "NAN".to_owned(),
            (Language::Python, false) if v.is_nan() => "math.nan".to_owned(),
            (l, false) => {
                let infinity = match l {
                    Language::Rust => "f64::INFINITY",
                    Language::C => "INFINITY",
                    Language::Python => "math.inf",
                };
                format!("{}{infinity}", if v < 0.0 { "-" } else { "" })
            }
        };
        if s.starts_with('-') { format!("({s})") } else { s }
    }

    fn operation(&self, op: Op, a: &str, b: &str) -> String {
        match op {
            Op::Add => format!("{a} + {b}"),
            Op::Sub => format!("{a} - {b}"),
            Op::Mul => format!("{a} * {b}"),
            Op::Div => format!("{a} / {b}"),
            Op::Neg => format!("-{a}"),
            Op::Sqrt => self.call("sqrt", &[a]),
            Op::Pow => self.call("pow", &[a, b]),
            // NaN stays NaN.
            Op::Call(Func::Sign) => {
                self.choice(&[(format!("{a} > 0.0"), "1.0"), (format!("{a} < 0.0"), "-1.0")], &format!("{a} * 0.0"))
            }
            Op::Call(f) => self.call(f.name(), &[a]),
            Op::Call2(Func2::Atan2) => self.call("atan2", &[a, b]),
            Op::Call2(f) => {
                let (less, or) = (if f == Func2::Min { "<" } else { ">" }, if self.is_python() { "or" } else { "||" });
                self.choice(&[(format!("{a} {less} {b} {or} {a} != {a}"), a)], b)
            }
        }
    }

    fn is_python(&self) -> bool {
        self.language == Language::Python
    }

    /// The first value whose condition holds.
    fn choice(&self, cases: &[(String, &str)], otherwise: &str) -> String {
        let mut out = String::new();
        for (condition, value) in cases {
            let _ = match self.language {
                Language::Rust => write!(out, "if {condition} {{ {value} }} else "),
                Language::C => write!(out, "{condition} ? {value} : "),
                Language::Python => write!(out, "{value} if {condition} else "),
            };
        }
        if self.language == Language::Rust { format!("{out}{{ {otherwise} }}") } else { out + otherwise }
    }

    fn call(&self, function: &str, arguments: &[&str]) -> String {
        let name = match (self.language, function) {
            (Language::Rust, "pow") => "f64::powf".to_owned(),
            (Language::Rust, "log") => "f64::ln".to_owned(),
            (Language::Rust, f) => format!("f64::{f}"),
            (Language::C | Language::Python, "abs") => format!("{}fabs", self.module()),
            (Language::C, f) => f.to_owned(),
            (Language::Python, f) => format!("math.{f}"),
        };
        format!("{name}({})", arguments.join(", "))
    }

    fn module(&self) -> &'static str {
        if self.is_python() { "math." } else { "" }
    }
}
