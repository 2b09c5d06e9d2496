//! N-ary products: a rational coefficient and powers of distinct bases.

use dashu_base::UnsignedAbs;
use dashu_int::{IBig, UBig};
use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use super::forms::{Product, Sum};
use super::order::compare_factors;
use super::sum::{has_sum, join, nodes};
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::terms;

/// Numbers are raised to powers up to this size; beyond it they stay symbolic.
const MAX_EXPONENT: i64 = 256;

/// `k` as a small integer.
fn small(k: &RBig) -> Option<i64> {
    if k.is_int() { i64::try_from(k.numerator()).ok().filter(|k| k.abs() <= MAX_EXPONENT) } else { None }
}

/// `c^k` where that is rational and of reasonable size.
fn number_power(c: &RBig, k: &RBig) -> Option<RBig> {
    if *c == RBig::ZERO {
        return (*k > RBig::ZERO).then_some(RBig::ZERO);
    }
    let (p, q) = (i64::try_from(k.numerator()).ok()?, u64::try_from(k.denominator()).ok()?);
    if p.abs() > MAX_EXPONENT || q > MAX_EXPONENT as u64 {
        return None;
    }
    let root = if q == 1 {
        c.clone()
    } else {
        if *c < RBig::ZERO {
            return None;
        }
        let exact = |n: &UBig| {
            let r = n.nth_root(q as usize);
            (r.pow(q as usize) == *n).then_some(r)
        };
        let (n, d) = (exact(&c.numerator().unsigned_abs())?, exact(c.denominator())?);
        RBig::from_parts(IBig::from(n), d)
    };
    let power = root.pow(p.unsigned_abs() as isize);
    Some(if p < 0 { RBig::ONE / power } else { power })
}

impl Product {
    pub(super) fn one() -> Product {
        Product { coefficient: RBig::ONE, powers: FxHashMap::default() }
    }

    /// The product `e`, which is canonical.
    pub(super) fn from(pool: &mut Pool, e: Expr) -> Product {
        let mut p = Product::one();
        p.times(pool, e, &RBig::ONE);
        p
    }

    /// Exponent of `base`; 0 if it is no factor.
    pub(super) fn exponent(&self, base: Expr) -> RBig {
        self.powers.get(&base).cloned().unwrap_or(RBig::ZERO)
    }

    /// Multiplies by `base^k` without looking into the base.
    pub(super) fn raise(&mut self, base: Expr, k: RBig) {
        let total = self.exponent(base) + k;
        if total == RBig::ZERO {
            self.powers.remove(&base);
        } else {
            self.powers.insert(base, total);
        }
    }

    /// Multiplies by `e^k`, where `e` is canonical.
    pub(super) fn times(&mut self, pool: &mut Pool, e: Expr, k: &RBig) {
        let mut stack = vec![(e, k.clone())];
        while let Some((e, k)) = stack.pop() {
            let whole = k.is_int();
            match pool.node(e) {
                Node::Num(_) => match pool.number(e).and_then(|c| number_power(c, &k)) {
                    Some(c) => self.coefficient *= c,
                    None => self.raise(e, k),
                },
                Node::Mul(a, b) if whole => stack.extend([(b, k.clone()), (a, k)]),
                Node::Pow(b, c) if whole => {
                    // (b^c)^k = b^(c k) holds for integer k whatever c is.
                    if let Some(c) = pool.number(c) {
                        let k = k * c;
                        stack.push((b, k));
                    } else {
                        let (q, r) = pool.coefficient(c);
                        let base = pool.intern(Node::Pow(b, r));
                        self.raise(base, q * k);
                    }
                }
                // exp is positive, so every power of it is an exponential.
                Node::Call(Func::Exp, u) => {
                    let (q, r) = pool.coefficient(u);
                    if let Node::Call(Func::Log, v) = pool.node(r) {
                        stack.push((v, q * k));
                    } else {
                        let base = pool.intern(Node::Call(Func::Exp, r));
                        self.raise(base, q * k);
                    }
                }
                Node::Add(..) if whole => {
                    let (content, primitive) = primitive(pool, e);
                    match number_power(&content, &k) {
                        Some(c) => {
                            self.coefficient *= c;
                            self.raise(primitive, k);
                        }
                        None => self.raise(e, k),
                    }
                }
                _ => self.raise(e, k),
            }
        }
        self.settle(pool);
    }

    /// Expands bases whose exponents have become integers.
    fn settle(&mut self, pool: &mut Pool) {
        loop {
            let open = self.powers.iter().find_map(|(&b, k)| {
                let even = small(k).is_some_and(|k| k % 2 == 0);
                let changed = match pool.node(b) {
                    Node::Num(_) => pool.number(b).is_some_and(|c| number_power(c, k).is_some()),
                    Node::Mul(..) => k.is_int(),
                    Node::Pow(_, c) => k.is_int() && pool.number(c).is_some(),
                    // |u|² = u²
                    Node::Call(Func::Abs, _) => even,
                    _ => false,
                };
                changed.then(|| (b, k.clone()))
            });
            let Some((b, k)) = open else { return };
            self.powers.remove(&b);
            let inner = if let Node::Call(Func::Abs, u) = pool.node(b) { u } else { b };
            self.times(pool, inner, &k);
        }
    }

    /// Bases and exponents, in order.
    pub(super) fn sorted(&self, pool: &Pool) -> Vec<(Expr, RBig)> {
        let mut all: Vec<(Expr, RBig)> = self.powers.iter().map(|(b, k)| (*b, k.clone())).collect();
        all.sort_by(|a, b| compare_factors(pool, a, b));
        all
    }

    /// The canonical expression.
    pub(super) fn build(&self, pool: &mut Pool) -> Expr {
        if self.coefficient == RBig::ZERO {
            return pool.int(0);
        }
        let mut sorted = self.sorted(pool);
        let mut coefficient = self.coefficient.clone();
        // The coefficient goes into the first sum where that takes fewer nodes; not into sums of products of sums,
        // where it would go down to the innermost.
        if coefficient != RBig::ONE
            && let Some((base, _)) =
                sorted.iter_mut().find(|(b, k)| *k == RBig::ONE && matches!(pool.node(*b), Node::Add(..)))
            && !terms(pool, *base).into_iter().any(|t| has_sum(pool, t))
        {
            let plain = Sum::from(pool, *base).sorted(pool);
            let scaled: Vec<_> = plain.iter().map(|(e, c)| (*e, c * &coefficient)).collect();
            if nodes(pool, &scaled, None) <= nodes(pool, &plain, Some(&coefficient)) {
                *base = join(pool, &scaled);
                coefficient = RBig::ONE;
            }
        }
        let mut product: Option<Expr> = None;
        for (base, k) in &sorted {
            let f = power(pool, *base, k);
            product = Some(product.map_or(f, |p| pool.intern(Node::Mul(p, f))));
        }
        match product {
            None => pool.rational(coefficient),
            Some(p) if coefficient == RBig::ONE => p,
            Some(p) => {
                let c = pool.rational(coefficient);
                pool.intern(Node::Mul(c, p))
            }
        }
    }

    /// The coefficient, and the canonical expression of the rest.
    pub(super) fn split(mut self, pool: &mut Pool) -> (RBig, Expr) {
        let c = std::mem::replace(&mut self.coefficient, RBig::ONE);
        let rest = self.build(pool);
        (c, rest)
    }

    /// The sum that results from multiplying out sums with positive integer exponents. A sum that would
    /// lead to more than `limit` terms stays a factor, as does one that is left when the pool reaches its limit of time or memory.
    pub(super) fn expand(&self, pool: &mut Pool, limit: usize) -> Expr {
        let mut rest = self.clone();
        let mut sums = Vec::new();
        for (base, k) in self.sorted(pool) {
            if let (Node::Add(..), Some(n)) = (pool.node(base), small(&k))
                && n > 0
            {
                rest.raise(base, -k);
                sums.push((base, n));
            }
        }
        if sums.is_empty() {
            return self.build(pool);
        }
        let first = rest.build(pool);
        let mut total = Sum::from(pool, first);
        let mut kept = Product::one();
        for (base, n) in sums {
            let factor = Sum::from(pool, base);
            for done in 0..n {
                if total.len() * factor.len() > limit || pool.reached_limit().is_some() {
                    kept.raise(base, RBig::from(n - done));
                    break;
                }
                total = total.times(pool, &factor);
            }
        }
        let total = total.build(pool);
        kept.times(pool, total, &RBig::ONE);
        kept.build(pool)
    }
}

/// [`Sum::primitive`], remembered: the terms of a sum may contain sums in turn.
fn primitive(pool: &mut Pool, sum: Expr) -> (RBig, Expr) {
    if let Some(known) = pool.primitives.get(&sum) {
        return known.clone();
    }
    let (content, primitive) = Sum::from(pool, sum).primitive(pool);
    pool.primitives.insert(sum, (content.clone(), primitive));
    pool.primitives.insert(primitive, (RBig::ONE, primitive));
    (content, primitive)
}

/// `base^k`, where `base` is as [`Product::times`] leaves it.
fn power(pool: &mut Pool, base: Expr, k: &RBig) -> Expr {
    match pool.node(base) {
        Node::Pow(b, r) if pool.number(r).is_none() => {
            let s = scale(pool, k, r);
            pool.pow(b, s)
        }
        Node::Call(Func::Exp, r) => {
            let s = scale(pool, k, r);
            pool.call(Func::Exp, s)
        }
        _ => {
            let k = pool.rational(k.clone());
            pool.pow(base, k)
        }
    }
}

/// `c · e` for a canonical `e`.
pub(super) fn scale(pool: &mut Pool, c: &RBig, e: Expr) -> Expr {
    let (q, rest) = pool.coefficient(e);
    let c = q * c;
    if c == RBig::ZERO {
        return pool.int(0);
    }
    if pool.is_one(rest) {
        return pool.rational(c);
    }
    if let Node::Add(..) = pool.node(rest) {
        let mut sum = Sum::default();
        sum.add(pool, rest, &c);
        return sum.build(pool);
    }
    if c == RBig::ONE {
        return rest;
    }
    let c = pool.rational(c);
    pool.intern(Node::Mul(c, rest))
}
