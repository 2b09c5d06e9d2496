//! An order of expressions that depends on their names and shapes, not on when they were made.

use std::cmp::Ordering;

use dashu_ratio::RBig;

use crate::func::{Func, Func2};
use crate::node::{Expr, Node};
use crate::pool::Pool;
use crate::text::{factors, terms};

/// Rank of the kinds of expressions: what is read first in a product comes first.
fn kind(node: Node) -> u8 {
    match node {
        Node::Num(_) => 0,
        Node::Pi => 1,
        Node::Sym(_) => 2,
        Node::Pow(..) => 3,
        Node::Mul(..) => 4,
        Node::Call(..) => 5,
        Node::Call2(..) => 6,
        Node::Add(..) => 7,
    }
}

/// Names by their letters, then by the number at their end: x2 before x10.
fn compare_names(a: &str, b: &str) -> Ordering {
    let split = |s: &str| {
        let stem = s.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let digits = s[stem..].trim_start_matches('0');
        (s[..stem].to_lowercase(), digits.len(), digits.to_owned(), s.to_owned())
    };
    split(a).cmp(&split(b))
}

fn function(f: Func) -> usize {
    Func::ALL.iter().position(|(g, _)| *g == f).unwrap_or(0)
}

fn function2(f: Func2) -> usize {
    Func2::ALL.iter().position(|(g, _)| *g == f).unwrap_or(0)
}

/// The first operands in which two lists differ, or the order of their lengths.
fn first_difference(a: &[Expr], b: &[Expr]) -> Result<(Expr, Expr), Ordering> {
    a.iter().zip(b).find(|(x, y)| x != y).map(|(&x, &y)| (x, y)).ok_or_else(|| a.len().cmp(&b.len()))
}

/// Total order of canonical expressions of one pool.
pub(super) fn compare(pool: &Pool, a: Expr, b: Expr) -> Ordering {
    compare_operands(pool, a, b, |e| if let Node::Mul(..) = pool.node(e) { factors(pool, e) } else { terms(pool, e) })
}

/// Total order of expressions of any nesting whose binary operands are in this order. Nothing is flattened:
/// a shared sum would be written out as often as it is used.
pub(super) fn compare_nested(pool: &Pool, a: Expr, b: Expr) -> Ordering {
    compare_operands(pool, a, b, |e| pool.node(e).operands().collect())
}

/// Different ids mean different structures, so one path down to the first difference decides.
fn compare_operands(pool: &Pool, mut a: Expr, mut b: Expr, operands: impl Fn(Expr) -> Vec<Expr>) -> Ordering {
    while a != b {
        let (x, y) = (pool.node(a), pool.node(b));
        let difference = match (x, y) {
            (Node::Num(_), Node::Num(_)) => return pool.number(a).cmp(&pool.number(b)),
            (Node::Sym(s), Node::Sym(t)) => return compare_names(pool.name(s), pool.name(t)),
            (Node::Pow(p, k), Node::Pow(q, l)) => first_difference(&[p, k], &[q, l]),
            (Node::Mul(..), Node::Mul(..)) | (Node::Add(..), Node::Add(..)) => {
                first_difference(&operands(a), &operands(b))
            }
            (Node::Call(f, p), Node::Call(g, q)) if f == g => Ok((p, q)),
            (Node::Call(f, _), Node::Call(g, _)) => return function(f).cmp(&function(g)),
            (Node::Call2(f, p, q), Node::Call2(g, r, s)) if f == g => first_difference(&[p, q], &[r, s]),
            (Node::Call2(f, ..), Node::Call2(g, ..)) => return function2(f).cmp(&function2(g)),
            _ => return kind(x).cmp(&kind(y)),
        };
        match difference {
            Ok((p, q)) => (a, b) = (p, q),
            Err(lengths) => return lengths,
        }
    }
    Ordering::Equal
}

/// Order of the factors of a product: numerator before denominator, then by base.
pub(super) fn compare_factors(pool: &Pool, a: &(Expr, RBig), b: &(Expr, RBig)) -> Ordering {
    let below = |k: &RBig| *k < RBig::ZERO;
    below(&a.1).cmp(&below(&b.1)).then_with(|| compare(pool, a.0, b.0)).then_with(|| b.1.cmp(&a.1))
}

/// The (base, exponent) pairs of a product without coefficient, in the order in which they stand.
fn powers(pool: &Pool, monomial: Expr) -> Vec<(Expr, RBig)> {
    factors(pool, monomial)
        .into_iter()
        .map(|f| match pool.node(f) {
            Node::Pow(b, k) => pool.number(k).map_or((f, RBig::ONE), |k| (b, k.clone())),
            _ => (f, RBig::ONE),
        })
        .collect()
}

/// What the terms of a sum are ordered by: total degree, highest first, then their factors.
pub(super) struct TermKey {
    degree: RBig,
    powers: Vec<(Expr, RBig)>,
}

impl TermKey {
    pub(super) fn new(pool: &Pool, monomial: Expr) -> TermKey {
        let powers = powers(pool, monomial);
        let constant = |e: Expr| matches!(pool.node(e), Node::Num(_) | Node::Pi);
        let degree = powers.iter().filter(|(b, _)| !constant(*b)).fold(RBig::ZERO, |d, (_, k)| d + k);
        TermKey { degree, powers }
    }

    pub(super) fn compare(&self, pool: &Pool, other: &TermKey) -> Ordering {
        other.degree.cmp(&self.degree).then_with(|| {
            self.powers
                .iter()
                .zip(&other.powers)
                .map(|(a, b)| compare_factors(pool, a, b))
                .find(|o| o.is_ne())
                .unwrap_or_else(|| self.powers.len().cmp(&other.powers.len()))
        })
    }
}
