//! Expressions to text that the parser reads back.

use std::cmp::Ordering;

use dashu_base::Abs;
use dashu_int::UBig;
use dashu_ratio::RBig;

use crate::node::{Expr, Node};
use crate::pool::Pool;
use rustc_hash::FxHashMap;

/// Binding strength, weakest first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Strength {
    Sum,
    Product,
    Power,
    Atom,
}

/// The terms of a (nested) sum, left to right; shared with the other printers.
pub(crate) fn terms(pool: &Pool, e: Expr) -> Vec<Expr> {
    flatten(pool, e, |n| if let Node::Add(a, b) = n { Some((a, b)) } else { None })
}

/// The terms of a sum in the order of print: a number leads the node, but reads better at the end.
pub(crate) fn sum_terms(pool: &Pool, e: Expr) -> Vec<Expr> {
    let mut all = terms(pool, e);
    if all.first().is_some_and(|&t| pool.number(t).is_some()) {
        all.rotate_left(1);
    }
    all
}

/// Printed terms as a sum, where a leading minus becomes a subtraction.
pub(crate) fn joined(printed: impl Iterator<Item = String>) -> String {
    let mut out = String::new();
    for (i, s) in printed.enumerate() {
        match (i, s.strip_prefix('-')) {
            (0, _) => out.push_str(&s),
            (_, Some(rest)) => {
                out.push_str(" - ");
                out.push_str(rest);
            }
            (_, None) => {
                out.push_str(" + ");
                out.push_str(&s);
            }
        }
    }
    out
}

/// The factors of a (nested) product, left to right.
pub(crate) fn factors(pool: &Pool, e: Expr) -> Vec<Expr> {
    flatten(pool, e, |n| if let Node::Mul(a, b) = n { Some((a, b)) } else { None })
}

fn flatten(pool: &Pool, e: Expr, split: impl Fn(Node) -> Option<(Expr, Expr)>) -> Vec<Expr> {
    let mut out = Vec::new();
    let mut stack = vec![e];
    while let Some(x) = stack.pop() {
        match split(pool.node(x)) {
            Some((a, b)) => {
                stack.push(b);
                stack.push(a);
            }
            None => out.push(x),
        }
    }
    out
}

/// A product taken apart for printing: sign, numerator and denominator factors with positive exponents.
pub(crate) struct Fraction {
    pub(crate) negative: bool,
    /// Absolute value of the numeric coefficient.
    pub(crate) coefficient: RBig,
    /// (base, exponent); the exponent is a positive number or any symbolic expression.
    pub(crate) top: Vec<(Expr, Exponent)>,
    /// (base, exponent), exponents positive.
    pub(crate) bottom: Vec<(Expr, Exponent)>,
}

#[derive(Clone)]
pub(crate) enum Exponent {
    Number(RBig),
    Symbolic(Expr),
}

pub(crate) fn fraction(pool: &Pool, e: Expr) -> Fraction {
    let mut f = Fraction { negative: false, coefficient: RBig::ONE, top: Vec::new(), bottom: Vec::new() };
    for x in factors(pool, e) {
        match pool.node(x) {
            Node::Num(_) => {
                if let Some(c) = pool.number(x) {
                    f.coefficient *= c;
                }
            }
            Node::Pow(b, k) => match pool.number(k) {
                Some(k) if *k < RBig::ZERO => f.bottom.push((b, Exponent::Number(-k.clone()))),
                Some(k) => f.top.push((b, Exponent::Number(k.clone()))),
                None => f.top.push((b, Exponent::Symbolic(k))),
            },
            _ => f.top.push((x, Exponent::Number(RBig::ONE))),
        }
    }
    f.negative = f.coefficient < RBig::ZERO;
    f.coefficient = f.coefficient.abs();
    f
}

/// A decimal where it is finite and short, `p/q` otherwise.
pub(crate) fn number_text(x: &RBig) -> (String, bool) {
    if x.is_int() {
        return (x.numerator().to_string(), true);
    }
    let mut q = x.denominator().clone();
    let mut digits = 0usize;
    for p in [2u8, 5] {
        let mut n = 0;
        while (&q % UBig::from(p)) == UBig::ZERO {
            q /= UBig::from(p);
            n += 1;
        }
        digits = digits.max(n);
    }
    if q == UBig::ONE && digits <= 12 {
        let scaled = x.clone() * RBig::from(UBig::from(10u8).pow(digits));
        let mut s = scaled.numerator().clone().abs().to_string();
        while s.len() <= digits {
            s.insert(0, '0');
        }
        s.insert(s.len() - digits, '.');
        if *x < RBig::ZERO {
            s.insert(0, '-');
        }
        return (s, true);
    }
    (format!("{}/{}", x.numerator(), x.denominator()), false)
}

/// Expressions that would print with more nodes than this are named by their size instead.
const MAX_PRINTED_NODES: f64 = 2e5;
/// The same for expressions nested deeper than this: printing descends into them.
const MAX_PRINTED_DEPTH: u32 = 2000;

impl Pool {
    /// Number of nodes that `e` has when nothing is shared, which is what its text repeats. Infinite beyond 1e308.
    pub fn tree_size(&self, e: Expr) -> f64 {
        let mut size: FxHashMap<Expr, f64> = FxHashMap::default();
        let mut total = 1.0;
        for n in self.reachable(&[e]) {
            total = 1.0 + self.node(n).operands().map(|o| size[&o]).sum::<f64>();
            size.insert(n, total);
        }
        total
    }

    /// Whether [`Pool::text`] writes the expression out.
    pub fn is_printable(&self, e: Expr) -> bool {
        let mut depth: FxHashMap<Expr, u32> = FxHashMap::default();
        for n in self.reachable(&[e]) {
            // Sums of sums and products of products are flattened before they are printed.
            let flat = |o: Expr| {
                matches!((self.node(n), self.node(o)), (Node::Add(..), Node::Add(..)) | (Node::Mul(..), Node::Mul(..)))
            };
            let level = self.node(n).operands().map(|o| depth[&o] + u32::from(!flat(o))).max().unwrap_or(0);
            depth.insert(n, level);
        }
        depth[&e] <= MAX_PRINTED_DEPTH && self.tree_size(e) <= MAX_PRINTED_NODES
    }

    /// The expression as text, in the syntax of model files. Sharing multiplies in print: an expression that is not
    /// [printable](Pool::is_printable) is only named by its size, which does not read back.
    pub fn text(&self, e: Expr) -> String {
        if self.is_printable(e) { self.write(e).0 } else { format!("<{:.0e} nodes, not shown>", self.tree_size(e)) }
    }

    fn wrapped(&self, e: Expr, at_least: Strength) -> String {
        let (s, strength) = self.write(e);
        if strength < at_least { format!("({s})") } else { s }
    }

    fn write(&self, e: Expr) -> (String, Strength) {
        match self.node(e) {
            Node::Num(_) => {
                let x = self.number(e).cloned().unwrap_or(RBig::ZERO);
                let (s, atomic) = number_text(&x);
                let strength = match (x.cmp(&RBig::ZERO), atomic) {
                    (Ordering::Less, _) => Strength::Sum,
                    (_, true) => Strength::Atom,
                    (_, false) => Strength::Product,
                };
                (s, strength)
            }
            Node::Pi => ("pi".into(), Strength::Atom),
            Node::Sym(s) => (self.name(s).to_owned(), Strength::Atom),
            Node::Call(f, a) => (format!("{}({})", f.name(), self.write(a).0), Strength::Atom),
            Node::Call2(f, a, b) => (format!("{}({}, {})", f.name(), self.write(a).0, self.write(b).0), Strength::Atom),
            Node::Add(..) => (self.write_sum(e), Strength::Sum),
            Node::Mul(..) | Node::Pow(..) => self.write_fraction(e),
        }
    }

    fn write_sum(&self, e: Expr) -> String {
        joined(sum_terms(self, e).into_iter().map(|t| self.wrapped(t, Strength::Sum)))
    }

    fn write_power(&self, base: Expr, k: &Exponent) -> (String, Strength) {
        let half = RBig::from(1) / RBig::from(2);
        match k {
            Exponent::Number(k) if *k == RBig::ONE => self.write(base),
            Exponent::Number(k) if *k == half => (format!("sqrt({})", self.write(base).0), Strength::Atom),
            Exponent::Number(k) => {
                let (s, atomic) = number_text(k);
                let s = if atomic { s } else { format!("({s})") };
                (format!("{}^{s}", self.wrapped(base, Strength::Atom)), Strength::Power)
            }
            Exponent::Symbolic(k) => (
                format!("{}^{}", self.wrapped(base, Strength::Atom), self.wrapped(*k, Strength::Atom)),
                Strength::Power,
            ),
        }
    }

    fn write_fraction(&self, e: Expr) -> (String, Strength) {
        let f = fraction(self, e);
        // Written once: a base that is nested deeply would otherwise be written twice at every level.
        let single = f.bottom.is_empty() && f.coefficient == RBig::ONE && !f.negative;
        if single && let [(b, k)] = f.top.as_slice() {
            return self.write_power(*b, k);
        }
        let side = |list: &[(Expr, Exponent)]| -> Vec<String> {
            list.iter()
                .map(|(b, k)| {
                    let (s, strength) = self.write_power(*b, k);
                    if strength < Strength::Power { format!("({s})") } else { s }
                })
                .collect()
        };
        let mut top = side(&f.top);
        let mut bottom = side(&f.bottom);
        if f.coefficient != RBig::ONE {
            let (s, atomic) = number_text(&f.coefficient);
            if atomic {
                top.insert(0, s);
            } else {
                if f.coefficient.numerator() != &IBIG_ONE || top.is_empty() {
                    top.insert(0, f.coefficient.numerator().to_string());
                }
                bottom.insert(0, f.coefficient.denominator().to_string());
            }
        }
        let mut s = if top.is_empty() { "1".to_owned() } else { top.join("*") };
        match bottom.len() {
            0 => {}
            1 => s = format!("{s}/{}", bottom[0]),
            _ => s = format!("{s}/({})", bottom.join("*")),
        }
        if f.negative {
            return (format!("-{s}"), Strength::Sum);
        }
        (s, Strength::Product)
    }
}

const IBIG_ONE: dashu_int::IBig = dashu_int::IBig::ONE;
