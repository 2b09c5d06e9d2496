//! The formula of an expression.

use dashu_ratio::RBig;

use super::tree::{Fence, Joint, Notation};
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::{Exponent, Strength, fraction, number_text, sum_terms};

fn function(f: Func) -> &'static str {
    match f {
        Func::Asin => "arcsin",
        Func::Acos => "arccos",
        Func::Atan => "arctan",
        Func::Log => "ln",
        Func::Sign => "sgn",
        _ => f.name(),
    }
}

/// A positive number; fractions stacked.
fn number(x: &RBig) -> Notation {
    let (text, atomic) = number_text(x);
    if atomic { Notation::Number(text) } else { digits(x.numerator()).over(digits(x.denominator())) }
}

fn digits(x: &impl ToString) -> Notation {
    Notation::Number(x.to_string())
}

fn applied(f: Notation, arguments: Vec<Notation>) -> Notation {
    Notation::Row(vec![f, Notation::List(Joint::Comma, arguments).fenced(Fence::Parentheses)])
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
        self.notation(e).latex()
    }

    /// The expression as a formula that can be printed, or become part of another one. An expression that is not
    /// [printable](Pool::is_printable) is named by its size.
    pub fn notation(&self, e: Expr) -> Notation {
        if self.is_printable(e) {
            self.layout(e).0
        } else {
            Notation::text(format!("{:.0e} nodes", self.tree_size(e))).fenced(Fence::Angles)
        }
    }

    fn layout(&self, e: Expr) -> (Notation, Strength) {
        match self.node(e) {
            Node::Num(_) => {
                let x = self.number(e).cloned().unwrap_or(RBig::ZERO);
                if x < RBig::ZERO {
                    (Notation::Negative(Box::new(number(&-x))), Strength::Sum)
                } else {
                    (number(&x), Strength::Atom)
                }
            }
            Node::Pi => (Notation::Sign('π'), Strength::Atom),
            Node::Sym(s) => (Notation::symbol(self.name(s)), Strength::Atom),
            Node::Call(Func::Abs, a) => (self.layout(a).0.fenced(Fence::Bars), Strength::Atom),
            Node::Call(f, a) => (applied(Notation::Function(function(f)), vec![self.layout(a).0]), Strength::Atom),
            Node::Call2(f, a, b) => {
                let arguments = vec![self.layout(a).0, self.layout(b).0];
                (applied(Notation::Function(f.name()), arguments), Strength::Atom)
            }
            Node::Add(..) => {
                let terms = sum_terms(self, e).into_iter().map(|t| self.layout(t).0);
                (Notation::Sum(terms.collect()), Strength::Sum)
            }
            Node::Mul(..) | Node::Pow(..) => self.fraction_layout(e),
        }
    }

    fn power_layout(&self, base: Expr, k: &Exponent) -> (Notation, Strength) {
        let half = RBig::from(1) / RBig::from(2);
        let exponent = match k {
            Exponent::Number(k) if *k == RBig::ONE => return self.layout(base),
            Exponent::Number(k) if *k == half => return (self.layout(base).0.root(), Strength::Atom),
            Exponent::Number(k) if k.is_int() => {
                // sin²(x), as it is usually written.
                if let Node::Call(f, a) = self.node(base)
                    && matches!(f, Func::Sin | Func::Cos | Func::Tan | Func::Sinh | Func::Cosh | Func::Tanh)
                {
                    let power = Notation::Function(function(f)).superscript(digits(k));
                    return (applied(power, vec![self.layout(a).0]), Strength::Power);
                }
                digits(k)
            }
            Exponent::Number(k) => {
                Notation::Row(vec![digits(k.numerator()), Notation::Sign('/'), digits(k.denominator())])
            }
            Exponent::Symbolic(k) => self.layout(*k).0,
        };
        let (formula, strength) = self.layout(base);
        let plain = match self.node(base) {
            Node::Call(f, _) => f == Func::Abs,
            Node::Call2(..) => false,
            _ => strength == Strength::Atom && self.number(base).is_none_or(RBig::is_int),
        };
        let formula = if plain { formula } else { formula.fenced(Fence::Parentheses) };
        (formula.superscript(exponent), Strength::Power)
    }

    fn fraction_layout(&self, e: Expr) -> (Notation, Strength) {
        let f = fraction(self, e);
        if let ([(base, k)], true, false) = (f.top.as_slice(), f.bottom.is_empty(), f.negative)
            && f.coefficient == RBig::ONE
        {
            return self.power_layout(*base, k);
        }
        // A decimal stays in front; other coefficients become part of the fraction.
        let (decimal, short) = number_text(&f.coefficient);
        let (above, below) = if short {
            (decimal, "1".to_owned())
        } else {
            (f.coefficient.numerator().to_string(), f.coefficient.denominator().to_string())
        };
        let formula = if f.bottom.is_empty() && below == "1" {
            self.product_layout(above, &f.top, false)
        } else {
            self.product_layout(above, &f.top, true).over(self.product_layout(below, &f.bottom, true))
        };
        if f.negative { (Notation::Negative(Box::new(formula)), Strength::Sum) } else { (formula, Strength::Product) }
    }

    /// Factors side by side, a coefficient of 1 left out; `delimited` if a single sum needs no parentheses.
    fn product_layout(&self, coefficient: String, list: &[(Expr, Exponent)], delimited: bool) -> Notation {
        let mut factors = Vec::new();
        if coefficient != "1" || list.is_empty() {
            factors.push(Notation::Number(coefficient));
        }
        let alone = delimited && list.len() == 1 && factors.is_empty();
        for (base, k) in list {
            let (formula, strength) = self.power_layout(*base, k);
            let weak = strength <= Strength::Product && !alone;
            factors.push(if weak { formula.fenced(Fence::Parentheses) } else { formula });
        }
        if factors.len() == 1 { factors.swap_remove(0) } else { Notation::Product(factors) }
    }
}
