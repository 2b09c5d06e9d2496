//! `abs`, `sign`, `min` and `max` case by case: in each case the signs of their arguments are given.

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::constants::exact_value;
use super::{Bindings, ZeroTest};
use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::terms;

/// More cases are not looked at.
const MAX_CASES: usize = 32;
/// Expressions with more nodes are not looked at.
const MAX_NODES: usize = 4000;

/// Expressions with more divisors are not looked at.
const MAX_DIVISORS: usize = 64;

/// Signs of expressions that are given in a case: true where positive.
type Signs = FxHashMap<Expr, bool>;

/// The sign of an expression: that of a product of expressions of open sign, or the opposite.
#[derive(Clone, PartialEq)]
struct Signature {
    positive: bool,
    /// Ascending; a square has no sign, so each at most once.
    open: Vec<Expr>,
}

impl Signature {
    fn of(positive: bool) -> Self {
        Self { positive, open: Vec::new() }
    }

    fn times(mut self, other: Signature) -> Self {
        self.positive ^= !other.positive;
        for e in other.open {
            match self.open.binary_search(&e) {
                Ok(i) => drop(self.open.remove(i)),
                Err(i) => self.open.insert(i, e),
            }
        }
        self
    }
}

impl Pool {
    /// The expressions in all cases, without `abs`, `sign`, `min`, `max` and roots of squares; together the cases
    /// cover almost all points at which the expressions have values.
    ///
    /// `None` if there are too many cases, or the rules say nothing new.
    pub(super) fn cases(&mut self, roots: &[Expr], bindings: &Bindings) -> Option<Vec<Vec<Expr>>> {
        if self.reachable(roots).len() > MAX_NODES {
            return None;
        }
        let bound = self.with_values(roots, bindings)?;
        if self.divides_by_zero(&bound)? {
            return None;
        }
        let facts = self.domain(&bound);
        let composed = self.composed(&bound);
        if composed == roots && !self.reachable(roots).iter().any(|&n| self.switches(n)) {
            return None;
        }
        let mut cases = Vec::new();
        self.split(composed, &Signs::default(), &facts, &mut cases)?;
        (!cases.is_empty()).then_some(cases)
    }

    /// The rational constants among the sub-expressions as numbers; `None` if something has no value.
    pub(super) fn with_values(&mut self, roots: &[Expr], bindings: &Bindings) -> Option<Vec<Expr>> {
        let mut exact: FxHashMap<Expr, RBig> = FxHashMap::default();
        let nodes = self.reachable(roots);
        for &n in &nodes {
            if let Some(v) = exact_value(self, n, bindings, &exact) {
                exact.insert(n, v);
            }
        }
        let is_zero = |e: Expr| exact.get(&e).is_some_and(|v| *v == RBig::ZERO);
        let undefined = |&n: &Expr| match self.node(n) {
            Node::Pow(b, k) => is_zero(b) && exact.get(&k).is_some_and(|k| *k < RBig::ZERO),
            Node::Call(Func::Log, a) => is_zero(a),
            _ => false,
        };
        if nodes.iter().any(undefined) {
            return None;
        }
        let numbers = exact.into_iter().map(|(n, v)| (n, self.rational(v))).collect();
        Some(self.substitute_all(roots, &numbers))
    }

    /// True if `e` is known to be positive, or zero, wherever it has a value.
    pub(crate) fn is_positive(&mut self, e: Expr) -> bool {
        self.signature(e, &Signs::default()) == Signature::of(true)
    }

    fn switches(&self, n: Expr) -> bool {
        matches!(self.node(n), Node::Call(Func::Abs | Func::Sign, _) | Node::Call2(Func2::Min | Func2::Max, ..))
    }

    /// True if something has no value anywhere, which a factor 0 beside it would hide; `None` if there is too much to
    /// be looked at.
    fn divides_by_zero(&mut self, roots: &[Expr]) -> Option<bool> {
        let mut divisors = Vec::new();
        for n in self.reachable(roots) {
            match self.node(n) {
                Node::Pow(b, k) if self.number(k).is_some_and(|k| *k < RBig::ZERO) => divisors.push(b),
                Node::Call(Func::Log, a) => divisors.push(a),
                Node::Call(Func::Tan, a) => divisors.push(self.cos(a)),
                _ => {}
            }
        }
        if divisors.len() > MAX_DIVISORS {
            return None;
        }
        Some(divisors.into_iter().any(|d| self.zero_directly(d, &Bindings::new()).is_zero()))
    }

    /// What must be positive for the expressions to have values: arguments of logarithms and of even roots. (A power
    /// with a symbolic exponent has values for negative bases where the exponent is an integer.)
    fn domain(&mut self, roots: &[Expr]) -> Vec<Signature> {
        let mut facts = Vec::new();
        for n in self.reachable(roots) {
            let positive = match self.node(n) {
                Node::Call(Func::Log, a) => Some(a),
                Node::Pow(a, k) => {
                    let even = |k: &RBig| k.denominator().trailing_zeros().is_some_and(|z| z > 0);
                    self.number(k).is_some_and(even).then_some(a)
                }
                _ => None,
            };
            if let Some(a) = positive {
                facts.push(self.signature(a, &Signs::default()));
            }
        }
        facts
    }

    fn split(
        &mut self,
        mut roots: Vec<Expr>,
        signs: &Signs,
        facts: &[Signature],
        cases: &mut Vec<Vec<Expr>>,
    ) -> Option<()> {
        // Nothing has a value in a case in which something that must be positive is negative.
        let negative = |f: &Signature| {
            let known: Option<Vec<bool>> = f.open.iter().map(|e| signs.get(e).copied()).collect();
            known.is_some_and(|k| k.iter().filter(|p| !**p).count() % 2 == usize::from(f.positive))
        };
        if facts.iter().any(negative) {
            return Some(());
        }
        loop {
            // Operands stand before their users, so the first one has no other below it.
            let Some(n) = self.reachable(&roots).into_iter().find(|&n| self.switches(n)) else {
                cases.push(roots);
                return (cases.len() <= MAX_CASES).then_some(());
            };
            let (u, choices) = match self.node(n) {
                Node::Call(Func::Abs, u) => (u, [u, self.neg(u)]),
                Node::Call(_, u) => (u, [self.int(1), self.int(-1)]),
                Node::Call2(Func2::Max, a, b) => (self.sub(a, b), [a, b]),
                Node::Call2(_, a, b) => (self.sub(a, b), [b, a]),
                _ => return None,
            };
            let zero = if let Node::Call(Func::Sign, _) = self.node(n) {
                match self.zero_directly(u, &Bindings::new()) {
                    ZeroTest::Zero(_) => true,
                    ZeroTest::NonZero => false,
                    ZeroTest::Unknown(_) => return None,
                }
            } else {
                false
            };
            let value = if zero {
                self.int(0)
            } else {
                let s = self.signature(u, signs);
                if let Some(&e) = s.open.first() {
                    for positive in [true, false] {
                        let mut more = signs.clone();
                        more.insert(e, positive);
                        self.split(roots.clone(), &more, facts, cases)?;
                    }
                    return Some(());
                }
                choices[usize::from(!s.positive)]
            };
            roots = self.substitute_all(&roots, &[(n, value)].into_iter().collect());
            roots = self.composed(&roots);
        }
    }

    /// The sign of `e` at almost all points, if `e` is not zero.
    fn signature(&mut self, e: Expr, signs: &Signs) -> Signature {
        let (coefficient, powers) = self.factored(e);
        let mut s = Signature::of(coefficient >= RBig::ZERO);
        for (base, k) in powers {
            // Even powers and even roots are positive.
            let odd = |zeros: Option<usize>| zeros == Some(0);
            if odd(k.numerator().trailing_zeros()) && odd(k.denominator().trailing_zeros()) {
                s = s.times(self.signature_of_base(base, signs));
            }
        }
        s
    }

    fn signature_of_base(&mut self, base: Expr, signs: &Signs) -> Signature {
        if let Some(&positive) = signs.get(&base) {
            return Signature::of(positive);
        }
        match self.node(base) {
            Node::Num(_) => Signature::of(self.number(base).is_some_and(|c| *c >= RBig::ZERO)),
            Node::Pi | Node::Call(Func::Exp | Func::Cosh | Func::Abs | Func::Acos, _) => Signature::of(true),
            Node::Pow(b, _) if self.signature(b, signs) == Signature::of(true) => Signature::of(true),
            Node::Call(Func::Sinh | Func::Tanh | Func::Atan | Func::Asin, a) => self.signature(a, signs),
            Node::Add(..) => {
                if self.symbols_of(&[base]).is_empty()
                    && let Some(s) = self.surd(base).and_then(|v| v.sign())
                {
                    return Signature::of(s >= 0);
                }
                let mut all = Vec::new();
                for t in terms(self, base) {
                    all.push(self.signature(t, signs));
                }
                match all.first() {
                    Some(first) if all.iter().all(|s| s == first) => first.clone(),
                    _ => Signature { positive: true, open: vec![base] },
                }
            }
            _ => Signature { positive: true, open: vec![base] },
        }
    }
}
