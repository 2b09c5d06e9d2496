//! Larger regions of attraction by other Lyapunov functions.

use std::time::Instant;

use bracketry_lie::MultivariatePolynomial;
use bracketry_symbolic::Rational;

use crate::certificate::{Certificate, Claim};
use crate::levels::{Levels, first_rise, numerical};
use crate::linearization::negative;
use crate::lyapunov::{sum_of_squares, unknown};
use crate::model::PolynomialModel;
use crate::monomials::monomials;
use crate::semidefinite::Limit;
use crate::sum_of_squares::program::{AffinePolynomial, Constraint, Program, Unsolved};
use crate::sum_of_squares::rounding::rounded;

/// Rounds of the iteration.
const ROUNDS: usize = 20;
/// Factors by which the set may grow in one round, the largest first: {W ≤ β} ⊂ {V ≤ 1} for the function W of the round before.
const GROWTH: [f64; 4] = [2.0, 1.4, 1.15, 1.04];
/// Most states: the programs grow fast.
const MAX_STATES: usize = 4;
/// Functions of the last rounds that are tried to be certified, the last first.
const LAST: usize = 4;

/// A certificate of a larger set {V ≤ c} with a V of degree at most `largest`, by alternating between the multiplier s at a fixed V and V at a
/// fixed s (Tan and Packard, IEEE Trans. Autom. Control 53 (2008) 565–571); none where the set does not grow.
pub(crate) fn expanded(
    model: &PolynomialModel,
    first: &Certificate,
    powers: &[i32],
    largest: u32,
    limit: &Limit,
) -> Option<Certificate> {
    let Claim::Region { function, level, .. } = &first.claim else { return None };
    if model.dimension() > MAX_STATES {
        return None;
    }
    // Half of the time that is left is for the exact check.
    let now = Instant::now();
    let deadline = limit.deadline.map(|d| now + d.saturating_duration_since(now) / 2);
    let search = Limit { deadline, stop: limit.stop.clone() };
    let mut functions = vec![normalized(function, level)];
    for _ in 0..ROUNDS {
        let Some(next) = functions.last().and_then(|w| round(model, w, powers, largest, &search)) else { break };
        functions.push(next);
    }
    let candidates = functions.iter().skip(1).rev().take(LAST);
    candidates.into_iter().find_map(|v| {
        let levels = Levels { model, v, limit, powers: powers.to_vec() };
        levels.largest(1.02).ok()
    })
}

/// V / c, whose set is {V ≤ 1}.
fn normalized(v: &MultivariatePolynomial, level: &Rational) -> MultivariatePolynomial {
    MultivariatePolynomial::default().plus(v, &(Rational::ONE / level))
}

/// A function V with {W ≤ β} ⊂ {V ≤ 1} for a factor β > 1, normalized so that V falls on {0 < V ≤ 1}.
fn round(
    model: &PolynomialModel,
    w: &MultivariatePolynomial,
    powers: &[i32],
    largest: u32,
    limit: &Limit,
) -> Option<MultivariatePolynomial> {
    let levels = Levels { model, v: w, limit, powers: powers.to_vec() };
    // A little inside, where the multiplier has a margin.
    let s = levels.multiplier(0.995).ok()??;
    for growth in GROWTH {
        match grown(model, w, &s, growth, powers, largest, limit) {
            Ok(Some(v)) => return renormalized(model, &v, powers, limit),
            Ok(None) => {}
            Err(_) => return None,
        }
    }
    None
}

/// V with V − … sums of squares: V itself, −V' − (1 − V) s, and 1 − V − σ (β − W) with a multiplier σ.
fn grown(
    model: &PolynomialModel,
    w: &MultivariatePolynomial,
    s: &MultivariatePolynomial,
    growth: f64,
    powers: &[i32],
    largest: u32,
    limit: &Limit,
) -> Result<Option<MultivariatePolynomial>, Unsolved> {
    let n = model.dimension();
    let template = monomials(n, 2..=largest);
    let of_v = unknown(&template).linear;
    // σ has degree 0 or 2: the sets are alike.
    let of_multiplier = unknown(&monomials(n, 0..=largest.saturating_sub(w.degree()))).linear;
    let count = of_v.len() + of_multiplier.len();
    let zero = MultivariatePolynomial::default;
    let columns = |v: &dyn Fn(&MultivariatePolynomial) -> MultivariatePolynomial,
                   sigma: &dyn Fn(&MultivariatePolynomial) -> MultivariatePolynomial| {
        of_v.iter().map(v).chain(of_multiplier.iter().map(sigma)).collect::<Vec<_>>()
    };
    let growth = Rational::try_from(growth).map_err(|_| Unsolved::NotFeasible)?;
    let one = MultivariatePolynomial::term(Rational::ONE, vec![0; n]);
    let positive = AffinePolynomial { constant: zero(), linear: columns(&Clone::clone, &|_| zero()) };
    let falls = AffinePolynomial {
        constant: negative(s),
        linear: columns(&|v| negative(&model.rate(v)).plus(&v.product(s), &Rational::ONE), &|_| zero()),
    };
    let inside = AffinePolynomial {
        constant: one.clone(),
        linear: columns(&negative, &|m| m.product(w).plus(m, &-growth.clone())),
    };
    let multiplier = AffinePolynomial { constant: zero(), linear: columns(&|_| zero(), &Clone::clone) };
    let with_constant = |p: AffinePolynomial| {
        let mut c = sum_of_squares(n, p);
        c.basis.insert(0, vec![0; n]);
        c
    };
    let constraints: Vec<Constraint> =
        vec![sum_of_squares(n, positive), sum_of_squares(n, falls), with_constant(inside), with_constant(multiplier)];
    let program = Program { unknowns: count, constraints, zero: Vec::new() };
    let Some(unknowns) = numerical(program, powers, limit)? else { return Ok(None) };
    let v = of_v.iter().zip(&unknowns).fold(zero(), |sum, (m, c)| sum.plus(m, c));
    Ok(Some(v))
}

/// V divided by the largest level below which it falls, at least 1 by construction.
fn renormalized(
    model: &PolynomialModel,
    v: &MultivariatePolynomial,
    powers: &[i32],
    limit: &Limit,
) -> Option<MultivariatePolynomial> {
    let above = first_rise(model, v)?.clamp(1.0, 1e3);
    let levels = Levels { model, v, limit, powers: powers.to_vec() };
    let (level, _) = levels.feasible(above).ok()?;
    if level < 0.99 {
        return None;
    }
    Some(short(&normalized(v, &Rational::try_from(level).ok()?)))
}

/// Coefficients rounded to 5 digits behind that of the largest: the exact check is of this function.
fn short(v: &MultivariatePolynomial) -> MultivariatePolynomial {
    let coefficients: Vec<f64> = v.terms().map(|(_, c)| c.to_f64().value()).collect();
    let coefficients = rounded(&coefficients, 5);
    let mut p = MultivariatePolynomial::default();
    for ((m, _), c) in v.terms().zip(coefficients) {
        p.add_term(m.clone(), c);
    }
    p
}
