//! Set-valued signs replaced by something with derivatives.

use bracketry_symbolic::{Expr, Func, Func2, Node, Pool};
use std::collections::HashMap;

/// Expressions with every switching function smoothed, and how fast the smoothed sign of each relaxes.
#[derive(Clone, Debug)]
pub struct Smoothed {
    /// The expressions, in the order given.
    pub expressions: Vec<Expr>,
    /// The distinct arguments of `sign`.
    pub arguments: Vec<Expr>,
}

/// Replaces `sign(s)` by `tanh(s/width)`, `abs(s)` by `sqrt(s² + width²)`, and `min`, `max` by their form with `abs`.
///
/// The width stays an indeterminate, so that one compiled function serves every step of a continuation.
pub fn smooth(pool: &mut Pool, roots: &[Expr], width: Expr) -> Smoothed {
    let mut image: HashMap<Expr, Expr> = HashMap::new();
    let mut arguments = Vec::new();
    for e in pool.reachable(roots) {
        let new = match pool.node(e) {
            Node::Num(_) | Node::Pi | Node::Sym(_) => e,
            Node::Add(a, b) => pool.add(image[&a], image[&b]),
            Node::Mul(a, b) => pool.mul(image[&a], image[&b]),
            Node::Pow(a, b) => pool.pow(image[&a], image[&b]),
            Node::Call(Func::Sign, a) => {
                let s = image[&a];
                if !arguments.contains(&s) {
                    arguments.push(s);
                }
                let scaled = pool.div(s, width);
                pool.call(Func::Tanh, scaled)
            }
            Node::Call(Func::Abs, a) => smooth_abs(pool, image[&a], width),
            Node::Call(f, a) => pool.call(f, image[&a]),
            Node::Call2(f @ (Func2::Min | Func2::Max), a, b) => {
                // min, max = (a + b ∓ |a − b|)/2
                let (a, b) = (image[&a], image[&b]);
                let gap = pool.sub(a, b);
                let distance = smooth_abs(pool, gap, width);
                let sum = pool.add(a, b);
                let twice = if f == Func2::Min { pool.sub(sum, distance) } else { pool.add(sum, distance) };
                let half = pool.ratio(1, 2);
                pool.mul(half, twice)
            }
            Node::Call2(f, a, b) => pool.call2(f, image[&a], image[&b]),
        };
        image.insert(e, new);
    }
    Smoothed { expressions: roots.iter().map(|e| image[e]).collect(), arguments }
}

fn smooth_abs(pool: &mut Pool, s: Expr, width: Expr) -> Expr {
    let s2 = pool.powi(s, 2);
    let w2 = pool.powi(width, 2);
    let sum = pool.add(s2, w2);
    pool.sqrt(sum)
}

/// For every sign argument s: the rate |∂(ds/dt)/∂ sign(s)| that, divided by the smoothing width, is the speed at which the
/// smoothed dynamics relax onto s = 0 (for Coulomb friction: μg). It decides how small an explicit integration step must be.
pub(crate) fn relaxation_rates(
    pool: &mut Pool,
    field: &[Expr],
    states: &[bracketry_symbolic::Symbol],
    arguments: &[Expr],
    width: Expr,
) -> Vec<Expr> {
    let mut rates = Vec::new();
    for (i, &s) in arguments.iter().enumerate() {
        let scaled = pool.div(s, width);
        let tanh = pool.call(Func::Tanh, scaled);
        let marker = pool.symbol(&format!("sign#{i}"));
        let marker_expr = pool.sym(marker);
        let map = std::iter::once((tanh, marker_expr)).collect();
        let marked = pool.substitute_all(field, &map);
        let terms: Vec<Expr> = states
            .iter()
            .zip(&marked)
            .map(|(&x, &f)| {
                let slope = pool.diff(s, x);
                let gain = pool.diff(f, marker);
                pool.mul(slope, gain)
            })
            .collect();
        let rate = pool.sum(terms);
        let back = std::iter::once((marker_expr, tanh)).collect();
        rates.push(pool.substitute(rate, &back));
    }
    rates
}
