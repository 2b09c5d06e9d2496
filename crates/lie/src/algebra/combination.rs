//! Linear combinations of expressions.

use bracketry_symbolic::{Expr, Pool, Rational, Real, Symbol};

/// Σ c_i e_i.
pub(crate) fn combination(pool: &mut Pool, list: &[Expr], coefficients: &[Expr]) -> Expr {
    let terms: Vec<Expr> = list.iter().zip(coefficients).map(|(&e, &c)| pool.mul(c, e)).collect();
    pool.sum(terms)
}

/// Σ c_i e_i with rational c_i.
pub(crate) fn rational_combination(pool: &mut Pool, list: &[Expr], coefficients: &[Rational]) -> Expr {
    let coefficients: Vec<Expr> = coefficients.iter().map(|c| pool.rational(c.clone())).collect();
    combination(pool, list, &coefficients)
}

/// Σ c_i e_i; `None` where a coefficient is too long for an expression.
pub(crate) fn real_combination(pool: &mut Pool, list: &[Expr], coefficients: &[Real]) -> Option<Expr> {
    let coefficients: Vec<Expr> = coefficients.iter().map(|c| c.expression(pool)).collect::<Option<_>>()?;
    Some(combination(pool, list, &coefficients))
}

/// The symbols as expressions.
pub(crate) fn symbols(pool: &mut Pool, list: &[Symbol]) -> Vec<Expr> {
    list.iter().map(|&s| pool.sym(s)).collect()
}
