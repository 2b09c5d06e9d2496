//! Normal forms that show identities between functions: trigonometric, exponential, and by common factors.

mod exponential;
mod monomial;
mod trigonometric;

use std::collections::BTreeMap;

use dashu_ratio::RBig;
use rustc_hash::FxHashMap;

use self::exponential::Exponential;
use self::trigonometric::Trigonometric;
use crate::func::Func;
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::{factors, terms};

/// Sums with more terms stay as they are.
const MAX_TERMS: usize = 400;
/// Expressions with more nodes stay as they are.
const MAX_NODES: usize = 5000;

/// Limits of the forms that [`Pool::simplify`] tries: terms, and nodes of the expression.
const MAX_TRIAL_TERMS: usize = 16;
const MAX_TRIAL_NODES: usize = 50;

impl Pool {
    /// The normal forms of `e` that may be shorter than `e`.
    pub(crate) fn shorter_forms(&mut self, e: Expr) -> Vec<Expr> {
        let nodes = self.reachable(&[e]);
        if nodes.len() > MAX_TRIAL_NODES {
            return Vec::new();
        }
        let (mut circular, mut exponential) = (0, 0);
        for n in nodes {
            match self.node(n) {
                Node::Call(Func::Sin | Func::Cos | Func::Tan, _) => circular += 1,
                Node::Call(Func::Exp | Func::Sinh | Func::Cosh | Func::Tanh, _) => exponential += 1,
                Node::Pow(_, k) if self.number(k).is_none() => exponential += 1,
                // Logarithms merge and part.
                Node::Call(Func::Log, _) => exponential += 2,
                _ => {}
            }
        }
        let mut forms = Vec::new();
        // A single function has no identities with itself that merging like terms does not show.
        if circular > 1 {
            forms.push(normal_form::<Trigonometric>(self, e, MAX_TRIAL_TERMS));
        }
        if exponential > 1 {
            forms.push(normal_form::<Exponential>(self, e, MAX_TRIAL_TERMS));
        }
        forms
    }
}

/// What a normal form does to the parts of an expression.
trait Form {
    /// A function written with the functions of the form; its arguments are in normal form.
    fn function(pool: &mut Pool, e: Expr) -> Expr;
    /// True if a factor with this base takes part in the form, so that it is brought to a common denominator.
    fn concerns(pool: &Pool, base: Expr) -> bool;
    /// The normal form of the sum of products that results from multiplying `e` out; `None` if it gets more terms than `limit`.
    fn polynomial(pool: &mut Pool, e: Expr, limit: usize) -> Option<BTreeMap<Expr, RBig>>;
}

/// The normal form of `e` and of the arguments of all functions in it.
fn normal_form<F: Form>(pool: &mut Pool, e: Expr, limit: usize) -> Expr {
    let nodes = pool.reachable(&[e]);
    if nodes.len() > MAX_NODES {
        return e;
    }
    let mut image: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut normal: FxHashMap<Expr, Expr> = FxHashMap::default();
    for n in nodes {
        let node = pool.node(n);
        let rational = match node {
            Node::Add(..) | Node::Mul(..) => true,
            // Denominators are quotients of their own.
            Node::Pow(_, k) => pool.integer(k).is_some_and(|k| k > 0),
            _ => false,
        };
        if !rational {
            for o in node.operands() {
                normal.entry(o).or_insert_with(|| quotient::<F>(pool, image[&o], limit));
            }
        }
        let made = pool.rebuild(n, |o| if rational { image[&o] } else { normal[&o] });
        let made = if matches!(node, Node::Num(_) | Node::Pi | Node::Sym(_)) || rational {
            made
        } else {
            F::function(pool, made)
        };
        image.insert(n, made);
    }
    quotient::<F>(pool, image[&e], limit)
}

/// Numerator in normal form over the common denominator of the functions concerned.
fn quotient<F: Form>(pool: &mut Pool, e: Expr, limit: usize) -> Expr {
    // Quotients of quotients become one before anything is multiplied out.
    let e = pool.collected(e);
    let all = pool.expanded_terms(e);
    if all.len() > limit {
        return e;
    }
    let mut denominators: BTreeMap<Expr, RBig> = BTreeMap::new();
    for t in all.iter().copied() {
        for (base, k) in pool.factored(t).1 {
            if k < RBig::ZERO && k.is_int() && F::concerns(pool, base) {
                let most = denominators.entry(base).or_insert(RBig::ZERO);
                if -k.clone() > *most {
                    *most = -k;
                }
            }
        }
    }
    let mut denominator = pool.int(1);
    for (base, k) in denominators {
        let k = pool.rational(k);
        let power = pool.pow(base, k);
        denominator = pool.mul(denominator, power);
    }
    let mut lifted = Vec::with_capacity(all.len());
    if denominator_terms(pool, denominator).saturating_mul(all.len()) > 4 * limit {
        return e;
    }
    for t in all {
        // What cancels must do so before anything is multiplied out.
        let product = pool.mul(t, denominator);
        lifted.push(pool.collected(product));
    }
    let lifted = pool.sum(lifted);
    let Some(numerator) = F::polynomial(pool, lifted, limit) else { return e };
    if numerator.is_empty() {
        return pool.int(0);
    }
    if pool.is_one(denominator) {
        return build(pool, &numerator);
    }
    // A numerator that is a multiple of the denominator leaves a number.
    if let Some(bottom) = F::polynomial(pool, denominator, limit)
        && bottom.keys().eq(numerator.keys())
    {
        let mut ratios = numerator.values().zip(bottom.values()).map(|(a, b)| a / b);
        let first = ratios.next().unwrap_or(RBig::ZERO);
        if ratios.all(|r| r == first) {
            return pool.rational(first);
        }
    }
    let top = build(pool, &numerator);
    let ratio = pool.div(top, denominator);
    pool.collected(ratio)
}

/// Number of terms that a product of powers of sums has at most when multiplied out.
fn denominator_terms(pool: &Pool, product: Expr) -> usize {
    let mut count = 1_usize;
    for f in factors(pool, product) {
        let (base, k) = match pool.node(f) {
            Node::Pow(b, k) => (b, pool.integer(k).unwrap_or(1)),
            _ => (f, 1),
        };
        for _ in 0..k.clamp(0, 64) {
            count = count.saturating_mul(terms(pool, base).len());
        }
    }
    count
}

/// Adds `c · term`.
fn accumulate(sum: &mut BTreeMap<Expr, RBig>, term: Expr, c: &RBig) {
    let total = sum.remove(&term).unwrap_or(RBig::ZERO) + c;
    if total != RBig::ZERO {
        sum.insert(term, total);
    }
}

/// Σ coefficient · term, in order.
fn build(pool: &mut Pool, sum: &BTreeMap<Expr, RBig>) -> Expr {
    let mut all = Vec::with_capacity(sum.len());
    for (&e, c) in sum {
        let c = pool.rational(c.clone());
        all.push(pool.mul(c, e));
    }
    let sum = pool.sum(all);
    pool.collected(sum)
}
