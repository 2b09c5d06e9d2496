//! Whether conditions can hold within the limits of the parameters.

use bracketry_symbolic::{Expr, Pool, Rational, Symbol};

use crate::algebra::rational::parametric::quotient;
use crate::algebra::rational::polynomial::{Budget, Polynomial};

/// Least and greatest value of each parameter.
pub(crate) type Limits = Vec<(Option<Rational>, Option<Rational>)>;

/// False where a condition is seen to have one sign within the limits, true where there are none, else `None`.
pub(crate) fn possible_within(
    pool: &mut Pool,
    conditions: &[Expr],
    symbols: &[Symbol],
    limits: &Limits,
) -> Option<bool> {
    if limits.iter().all(|l| l.0.is_none() && l.1.is_none()) {
        return None;
    }
    for &e in conditions {
        let (p, _) = quotient(pool, e, symbols, &mut Budget::new(10_000))?;
        if let Some((low, high)) = bounds(&p, limits)
            && (low.is_some_and(|l| l > Rational::ZERO) || high.is_some_and(|h| h < Rational::ZERO))
        {
            return Some(false);
        }
    }
    // A parameter that has a value, such as a = 0, or two that are equal, where their limits overlap.
    None
}

type Ends = (Option<Rational>, Option<Rational>);

/// An interval that holds all values; none for an end that is infinite.
fn bounds(p: &Polynomial, limits: &Limits) -> Option<Ends> {
    let mut total: Ends = (Some(Rational::ZERO), Some(Rational::ZERO));
    for (m, c) in p.terms() {
        let mut term: Ends = (Some(c.clone()), Some(c.clone()));
        for (i, &k) in m.iter().enumerate() {
            for _ in 0..k {
                term = product(&term, limits.get(i)?);
            }
        }
        let sum = |a: Option<Rational>, b: Option<Rational>| Some(a? + b?);
        total = (sum(total.0, term.0), sum(total.1, term.1));
    }
    Some(total)
}

fn product(a: &Ends, b: &Ends) -> Ends {
    if let ((Some(a0), Some(a1)), (Some(b0), Some(b1))) = (a, b) {
        let all = [a0 * b0, a0 * b1, a1 * b0, a1 * b1];
        return (all.iter().min().cloned(), all.iter().max().cloned());
    }
    // With an infinite end only the signs are followed.
    let sign = |x: &Ends| match x {
        (Some(l), _) if *l >= Rational::ZERO => Some((true, l.clone())),
        (_, Some(h)) if *h <= Rational::ZERO => Some((false, -h.clone())),
        _ => None,
    };
    match (sign(a), sign(b)) {
        (Some((p, x)), Some((q, y))) if p == q => (Some(x * y), None),
        (Some((_, x)), Some((_, y))) => (None, Some(-(x * y))),
        _ => (None, None),
    }
}
