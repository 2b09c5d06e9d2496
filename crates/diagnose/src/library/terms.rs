//! The terms of an equation.

use bracketry_symbolic::{Expr, Node, Pool, Symbol};
/// `∂e/∂s`, simplified.
pub(crate) fn slope(pool: &mut Pool, e: Expr, s: Symbol) -> Expr {
    let slope = pool.diff(e, s);
    pool.simplify(slope)
}

/// `∂e/∂s` where `e = ∂e/∂s · s`; `None` where it is not.
pub(crate) fn proportional(pool: &mut Pool, e: Expr, s: Symbol) -> Option<Expr> {
    let slope = pool.diff(e, s);
    let x = pool.sym(s);
    let line = pool.mul(slope, x);
    let difference = pool.sub(e, line);
    let difference = pool.simplify(difference);
    pool.is_zero(difference).then_some(slope)
}

/// The summands of a sum.
pub(crate) fn summands(pool: &Pool, e: Expr) -> Vec<Expr> {
    match pool.node(e) {
        Node::Add(a, b) => {
            let mut all = summands(pool, a);
            all.extend(summands(pool, b));
            all
        }
        _ => vec![e],
    }
}

/// The factors of a product.
pub(crate) fn factors(pool: &Pool, e: Expr) -> Vec<Expr> {
    match pool.node(e) {
        Node::Mul(a, b) => {
            let mut all = factors(pool, a);
            all.extend(factors(pool, b));
            all
        }
        _ => vec![e],
    }
}
