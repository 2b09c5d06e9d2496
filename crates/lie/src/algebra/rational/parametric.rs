//! Rational functions of parameters as quotients of polynomials, and back.

use bracketry_symbolic::{Expr, Pool, Symbol};

use super::polynomial::{Budget, Polynomial};
use super::readable::factored_in;
use super::ring::Ring;

/// Numerator and denominator of `e` as polynomials in the `parameters`, numbered as they stand; `None` if something
/// else occurs, or the expression is too large.
pub(crate) fn quotient(
    pool: &mut Pool,
    e: Expr,
    parameters: &[Symbol],
    budget: &mut Budget,
) -> Option<(Polynomial, Polynomial)> {
    let mut ring = Ring::default();
    for &s in parameters {
        let x = pool.sym(s);
        ring.atom(x);
    }
    let f = factored_in(pool, ring, e)?;
    if f.ring.atoms.len() > parameters.len() {
        return None;
    }
    let mut top = Polynomial::constant(&f.coefficient);
    let mut bottom = Polynomial::constant(&bracketry_symbolic::Rational::ONE);
    for (p, k) in &f.factors {
        let power = p.pow(k.unsigned_abs(), budget)?;
        if *k > 0 {
            top = top.mul(&power, budget)?;
        } else {
            bottom = bottom.mul(&power, budget)?;
        }
    }
    Some((top, bottom))
}

/// The polynomial as an expression.
pub(crate) fn expression(pool: &mut Pool, p: &Polynomial, parameters: &[Symbol]) -> Expr {
    let mut terms = Vec::with_capacity(p.len());
    for (m, c) in p.terms() {
        let mut term = pool.rational(c.clone());
        for (&s, &k) in parameters.iter().zip(m).filter(|x| *x.1 > 0) {
            let x = pool.sym(s);
            let power = pool.powi(x, i64::from(k));
            term = pool.mul(term, power);
        }
        terms.push(term);
    }
    let sum = pool.sum(terms);
    pool.simplify(sum)
}
