//! N-ary sums: rational coefficients of distinct products.

use std::collections::HashSet;

use dashu_base::{BitTest, Gcd, UnsignedAbs};
use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;

use super::forms::{Product, Sum};
use super::order::TermKey;
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::factors;

/// A common factor with more digits is left in the terms: through nested products it would double at every level.
const MAX_CONTENT_BITS: usize = 128;

/// Products and their coefficients.
type Terms = Vec<(Expr, RBig)>;

impl Sum {
    /// The sum `e`, which is canonical.
    pub(super) fn from(pool: &mut Pool, e: Expr) -> Sum {
        let mut s = Sum::default();
        s.add(pool, e, &RBig::ONE);
        s
    }

    /// Number of terms.
    pub(super) fn len(&self) -> usize {
        self.terms.len()
    }

    /// Adds `c · e`, where `e` is canonical.
    pub(super) fn add(&mut self, pool: &mut Pool, e: Expr, c: &RBig) {
        let mut stack = vec![(e, c.clone())];
        while let Some((e, c)) = stack.pop() {
            if let Node::Add(a, b) = pool.node(e) {
                stack.extend([(b, c.clone()), (a, c)]);
                continue;
            }
            let (q, rest) = pool.coefficient(e);
            let c = c * q;
            match pool.node(rest) {
                Node::Add(..) => stack.push((rest, c)),
                Node::Mul(..) if has_sum(pool, rest) => {
                    // A factor of the coefficient may stand inside the sum.
                    let (q, rest) = Product::from(pool, rest).split(pool);
                    self.add_term(rest, &(c * q));
                }
                _ => self.add_term(rest, &c),
            }
        }
    }

    fn add_term(&mut self, product: Expr, c: &RBig) {
        let total = self.terms.get(&product).map_or_else(|| c.clone(), |old| old + c);
        if total == RBig::ZERO {
            self.terms.remove(&product);
        } else {
            self.terms.insert(product, total);
        }
    }

    /// The product of two sums, multiplied out.
    pub(super) fn times(&self, pool: &mut Pool, other: &Sum) -> Sum {
        let mut out = Sum::default();
        for (&a, ca) in &self.terms {
            for (&b, cb) in &other.terms {
                let mut p = Product::from(pool, a);
                p.times(pool, b, &RBig::ONE);
                p.coefficient *= ca * cb;
                let e = p.build(pool);
                out.add(pool, e, &RBig::ONE);
            }
        }
        out
    }

    /// Products and their coefficients, in order.
    pub(super) fn sorted(&self, pool: &Pool) -> Vec<(Expr, RBig)> {
        let mut all: Vec<(TermKey, Expr, &RBig)> =
            self.terms.iter().map(|(e, c)| (TermKey::new(pool, *e), *e, c)).collect();
        all.sort_by(|a, b| a.0.compare(pool, &b.0));
        all.into_iter().map(|(_, e, c)| (e, c.clone())).collect()
    }

    /// Splits the sum into its content, a rational with the sign of the leading term, and a sum whose
    /// coefficients are integers without common divisor.
    pub(super) fn primitive(&self, pool: &mut Pool) -> (RBig, Expr) {
        let sorted = self.sorted(pool);
        let content = content(&sorted);
        let divided: Vec<_> = sorted.into_iter().map(|(e, c)| (e, c / &content)).collect();
        let primitive = join(pool, &divided);
        (content, primitive)
    }

    /// The canonical expression: terms in order, a common factor in front where that takes fewer nodes.
    pub(super) fn build(mut self, pool: &mut Pool) -> Expr {
        self.pythagoras(pool);
        let sorted = self.sorted(pool);
        if sorted.len() < 2 {
            return join(pool, &sorted);
        }
        let content = content(&sorted);
        let divided: Vec<_> = sorted.iter().map(|(e, c)| (*e, c / &content)).collect();
        if nodes(pool, &divided, Some(&content)) < nodes(pool, &sorted, None) {
            let sum = join(pool, &divided);
            let c = pool.rational(content);
            return pool.intern(Node::Mul(c, sum));
        }
        join(pool, &sorted)
    }

    /// Applies sin² + cos² = 1 as long as that leaves fewer terms.
    fn pythagoras(&mut self, pool: &mut Pool) {
        loop {
            let mut changed = false;
            let mut candidates = self.clone();
            candidates.terms.retain(|e, _| squares(pool, *e).next().is_some());
            for (term, _) in candidates.sorted(pool) {
                if let Some((old, new)) = self.pythagorean_step(pool, term) {
                    changed = true;
                    for (e, c) in old {
                        self.add_term(e, &-c);
                    }
                    for (e, c) in new {
                        self.add(pool, e, &c);
                    }
                }
            }
            if !changed {
                return;
            }
        }
    }

    /// Terms to take out, `term` among them, and fewer terms to put in for them.
    fn pythagorean_step(&self, pool: &mut Pool, term: Expr) -> Option<(Terms, Terms)> {
        let a = self.terms.get(&term)?.clone();
        let product = Product::from(pool, term);
        let all: Vec<_> = squares(pool, term).collect();
        for (base, f, u) in all {
            let co = if f == Func::Sin { Func::Cos } else { Func::Sin };
            let partner = pool.intern(Node::Call(co, u));
            let mut rest = product.clone();
            rest.raise(base, RBig::from(-2));
            let mut other = rest.clone();
            other.raise(partner, RBig::from(2));
            let (rest, other) = (rest.build(pool), other.build(pool));
            match (self.terms.get(&other), self.terms.get(&rest)) {
                // a m s² + a m c² = a m
                (Some(b), _) if *b == a => {
                    return Some((vec![(term, a.clone()), (other, a.clone())], vec![(rest, a)]));
                }
                // a m s² + b m c² = b m + (a − b) m s² is shorter if there is a term with m.
                (Some(b), Some(_)) => {
                    let old = vec![(term, a.clone()), (other, b.clone())];
                    return Some((old, vec![(rest, b.clone()), (term, &a - b)]));
                }
                // k m − k m s² = k m c²
                (None, Some(k)) if *k == -a.clone() => {
                    return Some((vec![(term, a), (rest, k.clone())], vec![(other, k.clone())]));
                }
                _ => {}
            }
        }
        None
    }
}

/// The sines and cosines with an integer exponent of at least 2 in a product: the base, the function, its argument.
fn squares(pool: &Pool, product: Expr) -> impl Iterator<Item = (Expr, Func, Expr)> {
    factors(pool, product).into_iter().filter_map(|f| {
        let Node::Pow(base, k) = pool.node(f) else { return None };
        let Node::Call(g @ (Func::Sin | Func::Cos), u) = pool.node(base) else { return None };
        pool.integer(k).is_some_and(|k| k >= 2).then_some((base, g, u))
    })
}

/// Greatest common divisor of the coefficients, with the sign of the first; 1 for none and where it is too long.
fn content(sorted: &[(Expr, RBig)]) -> RBig {
    let Some((_, first)) = sorted.first() else { return RBig::ONE };
    let (mut numerator, mut denominator) = (UBig::ZERO, UBig::ONE);
    for (_, c) in sorted {
        let (p, q) = (c.numerator().unsigned_abs(), c.denominator());
        numerator = if numerator == UBig::ZERO { p } else { (&numerator).gcd(&p) };
        let common = (&denominator).gcd(q);
        denominator = denominator * q / common;
        if numerator.bit_len().max(denominator.bit_len()) > MAX_CONTENT_BITS {
            return RBig::ONE;
        }
    }
    let size = RBig::from_parts(IBig::from(numerator), denominator);
    if *first < RBig::ZERO { -size } else { size }
}

/// True if a factor of the product is a sum.
pub(super) fn has_sum(pool: &Pool, product: Expr) -> bool {
    factors(pool, product).into_iter().any(|f| matches!(pool.node(f), Node::Add(..)))
}

/// Nodes that the coefficients of a sum take, with or without a common factor in front.
pub(super) fn nodes(pool: &Pool, sorted: &[(Expr, RBig)], factor: Option<&RBig>) -> usize {
    let mut numbers: HashSet<&RBig> = factor.into_iter().collect();
    let mut products = usize::from(factor.is_some());
    for (e, c) in sorted {
        let constant = pool.is_one(*e);
        if constant || *c != RBig::ONE {
            numbers.insert(c);
            products += usize::from(!constant);
        }
    }
    numbers.len() + products
}

/// The sum as an expression: the first positive term leads, and a constant stands in front as in the pool.
pub(super) fn join(pool: &mut Pool, sorted: &[(Expr, RBig)]) -> Expr {
    let mut constant: Option<Expr> = None;
    let mut sum: Option<Expr> = None;
    let first = sorted.iter().position(|(e, c)| *c > RBig::ZERO && !pool.is_one(*e)).unwrap_or(0);
    let order = sorted.get(first).into_iter().chain(sorted[..first].iter()).chain(sorted.iter().skip(first + 1));
    for (e, c) in order {
        if pool.is_one(*e) {
            constant = Some(pool.rational(c.clone()));
            continue;
        }
        let term = if *c == RBig::ONE {
            *e
        } else if has_sum(pool, *e) {
            let mut p = Product::from(pool, *e);
            p.coefficient *= c;
            p.build(pool)
        } else {
            let c = pool.rational(c.clone());
            pool.intern(Node::Mul(c, *e))
        };
        sum = Some(sum.map_or(term, |s| pool.intern(Node::Add(s, term))));
    }
    match (constant, sum) {
        (Some(c), Some(s)) => pool.intern(Node::Add(c, s)),
        (Some(e), None) | (None, Some(e)) => e,
        (None, None) => pool.int(0),
    }
}
