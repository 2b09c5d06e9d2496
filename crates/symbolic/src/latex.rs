//! Expressions to LaTeX (math mode), for reports and documents.

use dashu_ratio::RBig;

use crate::func::{Func, Func2};
use crate::pool::{Expr, Node, Pool};
use crate::text::{Exponent, fraction, joined, number_text, sum_terms};

/// Names that stand for a Greek letter.
const GREEK: [&str; 32] = [
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa", "lambda", "mu", "nu", "xi",
    "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi", "omega", "Gamma", "Delta", "Theta", "Lambda", "Xi", "Sigma",
    "Upsilon", "Phi", "Psi", "Omega",
];

/// How strongly the written form binds, weakest first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Strength {
    Sum,
    Product,
    Power,
    Atom,
}

/// A name without digits or underscores.
fn letters(name: &str) -> String {
    if GREEK.contains(&name) {
        return format!("\\{name}");
    }
    if name.chars().count() == 1 && name.chars().all(char::is_alphanumeric) {
        return name.to_owned();
    }
    let mut out = String::from("\\mathrm{");
    for c in name.chars() {
        match c {
            '_' | '%' | '#' | '&' | '$' | '{' | '}' => out.extend(['\\', c]),
            '\\' => out.push_str("\\backslash "),
            '^' | '~' => out.extend(['\\', c, '{', '}']),
            _ => out.push(c),
        }
    }
    out.push('}');
    out
}

/// Index of a name: digits as they are, anything else like a name.
fn index(part: &str) -> String {
    if part.chars().all(|c| c.is_ascii_digit()) { part.to_owned() } else { name(part) }
}

/// `theta_1`, `theta1` → `\theta_{1}`; `F_x_max` → `F_{x,\mathrm{max}}`.
fn name(text: &str) -> String {
    let mut parts = text.split('_').filter(|p| !p.is_empty());
    let Some(head) = parts.next() else { return letters(text) };
    let stem = head.trim_end_matches(|c: char| c.is_ascii_digit());
    let (stem, digits) = if stem.is_empty() { (head, "") } else { head.split_at(stem.len()) };
    let indices: Vec<String> =
        Some(digits.to_owned()).into_iter().filter(|d| !d.is_empty()).chain(parts.map(index)).collect();
    let stem = letters(stem);
    if indices.is_empty() { stem } else { format!("{stem}_{{{}}}", indices.join(",")) }
}

fn parentheses(s: &str) -> String {
    format!("\\left({s}\\right)")
}

fn function(f: Func) -> &'static str {
    match f {
        Func::Sin => "\\sin",
        Func::Cos => "\\cos",
        Func::Tan => "\\tan",
        Func::Asin => "\\arcsin",
        Func::Acos => "\\arccos",
        Func::Atan => "\\arctan",
        Func::Sinh => "\\sinh",
        Func::Cosh => "\\cosh",
        Func::Tanh => "\\tanh",
        Func::Exp => "\\exp",
        Func::Log => "\\ln",
        Func::Abs => "\\operatorname{abs}",
        Func::Sign => "\\operatorname{sgn}",
    }
}

/// A positive number; fractions stacked.
fn number(x: &RBig) -> String {
    let (s, atomic) = number_text(x);
    if atomic { s } else { format!("\\frac{{{}}}{{{}}}", x.numerator(), x.denominator()) }
}

impl Pool {
    /// The expression in LaTeX, to be put between `$`.
    ///
    /// Names of Greek letters become letters, digits at the end of a name and what follows `_` become indices,
    /// and other names of several letters are set upright.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("mu*x1^2/sqrt(2*theta)").unwrap();
    /// assert_eq!(p.latex(e), r"\frac{\mu x_{1}^{2}}{\sqrt{2 \theta}}");
    /// ```
    pub fn latex(&self, e: Expr) -> String {
        if self.is_printable(e) {
            self.write_latex(e).0
        } else {
            format!("\\langle\\text{{{:.0e} nodes}}\\rangle", self.tree_size(e))
        }
    }

    fn write_latex(&self, e: Expr) -> (String, Strength) {
        match self.node(e) {
            Node::Num(_) => {
                let x = self.number(e).cloned().unwrap_or(RBig::ZERO);
                if x < RBig::ZERO { (format!("-{}", number(&-x)), Strength::Sum) } else { (number(&x), Strength::Atom) }
            }
            Node::Pi => ("\\pi".into(), Strength::Atom),
            Node::Sym(s) => (name(self.name(s)), Strength::Atom),
            Node::Call(Func::Abs, a) => (format!("\\left|{}\\right|", self.write_latex(a).0), Strength::Atom),
            Node::Call(f, a) => (format!("{}{}", function(f), parentheses(&self.write_latex(a).0)), Strength::Atom),
            Node::Call2(f, a, b) => {
                let f = match f {
                    Func2::Atan2 => "\\operatorname{atan2}",
                    Func2::Min => "\\min",
                    Func2::Max => "\\max",
                };
                (
                    format!("{f}{}", parentheses(&format!("{}, {}", self.write_latex(a).0, self.write_latex(b).0))),
                    Strength::Atom,
                )
            }
            Node::Add(..) => (self.latex_sum(e), Strength::Sum),
            Node::Mul(..) | Node::Pow(..) => self.latex_fraction(e),
        }
    }

    fn latex_sum(&self, e: Expr) -> String {
        joined(sum_terms(self, e).into_iter().map(|t| self.write_latex(t).0))
    }

    fn latex_power(&self, base: Expr, k: &Exponent) -> (String, Strength) {
        let half = RBig::from(1) / RBig::from(2);
        let exponent = match k {
            Exponent::Number(k) if *k == RBig::ONE => return self.write_latex(base),
            Exponent::Number(k) if *k == half => {
                return (format!("\\sqrt{{{}}}", self.write_latex(base).0), Strength::Atom);
            }
            Exponent::Number(k) if k.is_int() => {
                // sin²(x), as it is usually written.
                if let Node::Call(f, a) = self.node(base)
                    && matches!(f, Func::Sin | Func::Cos | Func::Tan | Func::Sinh | Func::Cosh | Func::Tanh)
                {
                    let s = format!("{}^{{{k}}}{}", function(f), parentheses(&self.write_latex(a).0));
                    return (s, Strength::Power);
                }
                k.to_string()
            }
            Exponent::Number(k) => format!("{}/{}", k.numerator(), k.denominator()),
            Exponent::Symbolic(k) => self.write_latex(*k).0,
        };
        let (s, strength) = self.write_latex(base);
        let function = match self.node(base) {
            Node::Call(f, _) => f != Func::Abs,
            Node::Call2(..) => true,
            _ => false,
        };
        let plain = strength == Strength::Atom && !function;
        let plain = plain && self.number(base).is_none_or(RBig::is_int);
        let s = if plain { s } else { parentheses(&s) };
        (format!("{s}^{{{exponent}}}"), Strength::Power)
    }

    fn latex_fraction(&self, e: Expr) -> (String, Strength) {
        let f = fraction(self, e);
        if let ([(base, k)], true, false) = (f.top.as_slice(), f.bottom.is_empty(), f.negative)
            && f.coefficient == RBig::ONE
        {
            return self.latex_power(*base, k);
        }
        let (numerator, denominator) =
            (f.coefficient.numerator().to_string(), RBig::from(f.coefficient.denominator().clone()));
        // A decimal stays in front; other coefficients become part of the fraction.
        let (decimal, short) = number_text(&f.coefficient);
        let (above, below) = if short { (decimal, "1".to_owned()) } else { (numerator, number_text(&denominator).0) };
        let s = if f.bottom.is_empty() && below == "1" {
            self.latex_product(&above, &f.top, false)
        } else {
            let (above, below) =
                (self.latex_product(&above, &f.top, true), self.latex_product(&below, &f.bottom, true));
            format!("\\frac{{{above}}}{{{below}}}")
        };
        if f.negative { (format!("-{s}"), Strength::Sum) } else { (s, Strength::Product) }
    }

    /// Factors side by side, a coefficient of 1 left out; `delimited` if a single sum needs no parentheses.
    fn latex_product(&self, coefficient: &str, list: &[(Expr, Exponent)], delimited: bool) -> String {
        let mut parts: Vec<String> = Vec::new();
        if coefficient != "1" || list.is_empty() {
            parts.push(coefficient.to_owned());
        }
        let alone = delimited && list.len() == 1 && parts.is_empty();
        for (base, k) in list {
            let (s, strength) = self.latex_power(*base, k);
            parts.push(if strength <= Strength::Product && !alone { parentheses(&s) } else { s });
        }
        let mut out = String::new();
        for s in parts {
            if !out.is_empty() {
                // Two numbers side by side would read as one.
                out.push_str(if s.starts_with(|c: char| c.is_ascii_digit()) { " \\cdot " } else { " " });
            }
            out.push_str(&s);
        }
        out
    }
}
