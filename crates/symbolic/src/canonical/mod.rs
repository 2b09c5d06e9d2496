//! Canonical form: n-ary sums and products with exact coefficients, in an order that only names decide.
//!
//! The pool itself keeps sums and products binary, which preserves sharing. This
//! pass flattens them, merges what is alike, and orders the rest for reading.

mod forms;
mod order;
mod product;
mod sum;

use std::cmp::Ordering;
use std::collections::BTreeMap;

use dashu_ratio::RBig;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::terms;
use forms::{Product, Sum};
use product::scale;

/// Terms beyond which [`Pool::expand`] keeps a factor.
const MAX_TERMS: usize = 1000;

/// The same within [`Pool::simplify`], which only tries whether expanding helps.
const MAX_TRIAL_TERMS: usize = 60;

/// Expressions with more nodes are simplified without trying to expand them.
const MAX_TRIAL_NODES: usize = 300;

/// Terms in all sums together beyond which [`Pool::collected`] gives up.
const MAX_COLLECTED_TERMS: usize = 20_000;

/// Terms per node of the expression after which [`Pool::simplify`] gives a canonical form up: sums that are shared
/// by sums are written out in each of them, and a result so long would not be simpler.
const EFFORT_PER_NODE: usize = 4;

impl Pool {
    /// An order of expressions by their names and shapes, not by when they were made.
    pub fn compare(&self, a: Expr, b: Expr) -> Ordering {
        order::compare(self, a, b)
    }

    /// An equal expression that is shorter or the same: like terms and like factors merged, rational
    /// coefficients collected, sin² + cos² = 1 applied where it shortens, products multiplied out where that
    /// makes terms cancel, the [trigonometric](Pool::trig_form) or [exponential](Pool::exp_form) normal form taken
    /// where it is shorter, and everything in an order that depends on names only.
    ///
    /// The result has at most as many distinct nodes, equals `e` wherever `e` has a value (canceled factors may
    /// give it one elsewhere), and is left as it is by another call.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("(x + y)^2 - x^2 - y*(y + x) + m*sin(q)^2 + m*cos(q)^2").unwrap();
    /// let s = p.simplify(e);
    /// assert_eq!(p.text(s), "x*y + m");
    /// ```
    pub fn simplify(&mut self, e: Expr) -> Expr {
        if self.reached_limit().is_some() {
            return e;
        }
        let mut now = e;
        // Every round but the last has fewer nodes than the one before.
        loop {
            let next = self.simpler(now);
            if next == Some(now) {
                return now;
            }
            if let Some(next) = next {
                let (old, new) = (self.size(now), self.size(next));
                if new < old || (new == old && self.simpler(next) == Some(next)) {
                    now = next;
                    continue;
                }
            }
            // Flattening would lose sharing; at least the order of operands is made independent of history.
            let ordered = reordered(self, now);
            if ordered == now {
                return now;
            }
            now = ordered;
        }
    }

    /// The products in `e` multiplied out over sums, like terms merged.
    ///
    /// A factor that would lead to a sum of more than 1000 terms is kept as it is.
    ///
    /// ```
    /// # use bracketry_symbolic::Pool;
    /// let mut p = Pool::new();
    /// let e = p.parse("(a + b)^2*(a - b)").unwrap();
    /// let s = p.expand(e);
    /// assert_eq!(p.text(s), "a^3 + a^2*b - a*b^2 - b^3");
    /// ```
    pub fn expand(&mut self, e: Expr) -> Expr {
        // Quotients of quotients become one, and factors cancel, before anything is multiplied out.
        let e = self.collected(e);
        canonical(self, e, Some(MAX_TERMS), usize::MAX).unwrap_or(e)
    }

    /// Like terms and like factors merged and everything in order, products kept as they are; `e` itself if that
    /// would be very long.
    pub(crate) fn collected(&mut self, e: Expr) -> Expr {
        canonical(self, e, None, MAX_COLLECTED_TERMS).unwrap_or(e)
    }

    /// The terms of `e` multiplied out, without a common factor in front.
    pub(crate) fn expanded_terms(&mut self, e: Expr) -> Vec<Expr> {
        let e = self.expand(e);
        let (c, rest) = self.coefficient(e);
        if c == RBig::ONE || !matches!(self.node(rest), Node::Add(..)) {
            return terms(self, e);
        }
        let c = self.rational(c);
        terms(self, rest).into_iter().map(|t| self.mul(c, t)).collect()
    }

    /// `e` as a coefficient and powers of distinct bases: Π base^exponent, sums without common factor.
    pub(crate) fn factored(&mut self, e: Expr) -> (RBig, Vec<(Expr, RBig)>) {
        let e = self.collected(e);
        let product = Product::from(self, e);
        let powers = product.sorted(self);
        (product.coefficient, powers)
    }

    /// The smallest of the canonical forms of `e`; `None` if that is out of reach.
    fn simpler(&mut self, e: Expr) -> Option<Expr> {
        let nodes = self.size(e);
        let effort = EFFORT_PER_NODE * nodes;
        let collected = canonical(self, e, None, effort)?;
        if nodes > MAX_TRIAL_NODES {
            return Some(collected);
        }
        let mut best = collected;
        if let Some(expanded) = canonical(self, collected, Some(MAX_TRIAL_TERMS), effort)
            && self.size(expanded) < self.size(best)
        {
            best = expanded;
        }
        for form in self.shorter_forms(e) {
            if self.size(form) < self.size(best) {
                best = form;
            }
        }
        Some(best)
    }

    /// Number of distinct nodes.
    fn size(&self, e: Expr) -> usize {
        self.reachable(&[e]).len()
    }
}

/// The same nodes with the operands of every binary sum and product in order, numbers first.
fn reordered(pool: &mut Pool, e: Expr) -> Expr {
    let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
    for n in pool.reachable(&[e]) {
        let pair = |a, b| {
            let (a, b) = (image[&a], image[&b]);
            if order::compare_nested(pool, a, b).is_gt() { (b, a) } else { (a, b) }
        };
        let node = match pool.node(n) {
            Node::Add(a, b) => {
                let (a, b) = pair(a, b);
                Node::Add(a, b)
            }
            Node::Mul(a, b) => {
                let (a, b) = pair(a, b);
                Node::Mul(a, b)
            }
            other => other.with_operands(|o| image[&o]),
        };
        let made = pool.intern(node);
        image.insert(n, made);
    }
    image[&e]
}

/// The canonical form of `e`, with products multiplied out up to a number of terms if one is given; `None` if its
/// sums have more than `effort` terms altogether.
fn canonical(pool: &mut Pool, e: Expr, expand: Option<usize>, effort: usize) -> Option<Expr> {
    let nodes = pool.reachable(&[e]);
    // Sums within sums and products within products are taken in by the outermost one.
    let mut outermost: FxHashSet<Expr> = [e].into_iter().collect();
    for &n in &nodes {
        let node = pool.node(n);
        outermost.extend(node.operands().filter(|o| {
            !matches!((node, pool.node(*o)), (Node::Add(..), Node::Add(..)) | (Node::Mul(..), Node::Mul(..)))
        }));
    }
    let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut written = 0;
    for n in nodes {
        if !outermost.contains(&n) {
            continue;
        }
        if pool.reached_limit().is_some() {
            return None;
        }
        let c = match pool.node(n) {
            Node::Num(_) | Node::Pi | Node::Sym(_) => n,
            Node::Add(..) => collect_sum(pool, n, &image),
            Node::Mul(..) => {
                let p = collect_product(pool, n, &image);
                finish(pool, &p, expand)
            }
            Node::Pow(b, k) => {
                let (b, k) = (image[&b], image[&k]);
                let mut p = Product::one();
                if let Some(k) = pool.number(k).cloned() {
                    p.times(pool, b, &k);
                } else {
                    let power = pool.pow(b, k);
                    p.times(pool, power, &RBig::ONE);
                }
                finish(pool, &p, expand)
            }
            Node::Call(f, a) => call(pool, f, image[&a]),
            Node::Call2(f, a, b) => call2(pool, f, image[&a], image[&b]),
        };
        image.insert(n, c);
        if let Node::Add(..) = pool.node(c) {
            written += terms(pool, c).len();
            if written > effort {
                return None;
            }
        }
    }
    image.get(&e).copied()
}

fn finish(pool: &mut Pool, p: &Product, expand: Option<usize>) -> Expr {
    match expand {
        Some(limit) => p.expand(pool, limit),
        None => p.build(pool),
    }
}

/// The terms below a sum, each visited once: operands have smaller ids than their users.
fn collect_sum(pool: &mut Pool, n: Expr, image: &FxHashMap<Expr, Expr>) -> Expr {
    let mut pending: BTreeMap<Expr, RBig> = [(n, RBig::ONE)].into();
    let mut sum = Sum::default();
    while let Some((x, c)) = pending.pop_last() {
        if let Node::Add(a, b) = pool.node(x) {
            for o in [a, b] {
                *pending.entry(o).or_insert(RBig::ZERO) += &c;
            }
        } else {
            sum.add(pool, image[&x], &c);
        }
    }
    sum.build(pool)
}

/// The factors below a product, likewise.
fn collect_product(pool: &mut Pool, n: Expr, image: &FxHashMap<Expr, Expr>) -> Product {
    let mut pending: BTreeMap<Expr, RBig> = [(n, RBig::ONE)].into();
    let mut product = Product::one();
    while let Some((x, k)) = pending.pop_last() {
        if let Node::Mul(a, b) = pool.node(x) {
            for o in [a, b] {
                *pending.entry(o).or_insert(RBig::ZERO) += &k;
            }
        } else {
            product.times(pool, image[&x], &k);
        }
    }
    product
}

/// `f(a)`, where the argument of an odd or even function starts with a positive term.
fn call(pool: &mut Pool, f: Func, a: Expr) -> Expr {
    let odd = matches!(f, Func::Sin | Func::Tan | Func::Asin | Func::Atan | Func::Sinh | Func::Tanh | Func::Sign);
    let even = matches!(f, Func::Cos | Func::Cosh | Func::Abs);
    if (odd || even)
        && let Node::Add(..) = pool.node(a)
        && Sum::from(pool, a).primitive(pool).0 < RBig::ZERO
    {
        let minus = RBig::from(-1);
        let positive = scale(pool, &minus, a);
        let value = pool.call(f, positive);
        return if odd { scale(pool, &minus, value) } else { value };
    }
    let value = pool.call(f, a);
    // exp(k log x) is a power.
    if f == Func::Exp { Product::from(pool, value).build(pool) } else { value }
}

fn call2(pool: &mut Pool, f: Func2, a: Expr, b: Expr) -> Expr {
    match f {
        Func2::Min | Func2::Max if order::compare(pool, b, a).is_lt() => pool.call2(f, b, a),
        _ => pool.call2(f, a, b),
    }
}
