//! Exact values of a numerical solution.

use bracketry_symbolic::{Bindings, Expr, Pool, Rational, Symbol, Tape};
use rustc_hash::FxHashMap;

/// How near a number has to be to a simple constant that is tried.
const NEAR: f64 = 1e-8;

/// Largest denominators of constants that are tried, the simplest kind first.
const DENOMINATORS: [i64; 2] = [1000, 100_000];

/// Values of the free variables at which the equations, with parameters at their values, vanish exactly. Variables that an
/// equation determines linearly are solved for; others are guessed as rational numbers, multiples of π, and square roots.
/// `None` where the guess is not confirmed.
pub(crate) fn confirmed(
    pool: &mut Pool,
    equations: &[Expr],
    free: &[Symbol],
    z: &[f64],
    slack: f64,
) -> Option<Vec<Expr>> {
    let mut known: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut open: Vec<usize> = (0..free.len()).collect();
    while !open.is_empty() {
        let current = pool.substitute_all(equations, &known);
        let solved = current.iter().find_map(|&e| {
            let uses = pool.symbols_of(&[e]);
            let mut unknown = open.iter().copied().filter(|&k| uses.contains(&free[k]));
            let (Some(k), None) = (unknown.next(), unknown.next()) else { return None };
            let value = linear_root(pool, e, free[k])?;
            near(pool, value, z[k], slack).then_some((k, value))
        });
        let (k, value) = match solved {
            Some(found) => found,
            None => open.iter().find_map(|&k| Some((k, constant(pool, z[k], slack)?)))?,
        };
        let variable = pool.sym(free[k]);
        known.insert(variable, value);
        open.retain(|&other| other != k);
    }
    let values: Vec<Expr> = free
        .iter()
        .map(|&s| {
            let s = pool.sym(s);
            known[&s]
        })
        .collect();
    for e in pool.substitute_all(equations, &known) {
        let e = pool.simplify(e);
        if !pool.is_zero(e) && !pool.zero_test(e, &Bindings::default()).is_zero() {
            return None;
        }
    }
    Some(values)
}

/// The root of an expression that is affine in the symbol and has no other.
fn linear_root(pool: &mut Pool, e: Expr, s: Symbol) -> Option<Expr> {
    let slope = pool.diff(e, s);
    let slope = pool.simplify(slope);
    if pool.depends_on(slope, s) || !pool.zero_test(slope, &Bindings::default()).is_nonzero() {
        return None;
    }
    let (variable, zero) = (pool.sym(s), pool.int(0));
    let rest = pool.substitute(e, &FxHashMap::from_iter([(variable, zero)]));
    let negative = pool.neg(rest);
    let root = pool.div(negative, slope);
    Some(pool.simplify(root))
}

fn near(pool: &Pool, e: Expr, value: f64, slack: f64) -> bool {
    let Ok(tape) = Tape::compile(pool, &[], &[e]) else { return false };
    let mut out = [f64::NAN];
    tape.eval(&[], &mut Vec::new(), &mut out);
    (out[0] - value).abs() <= slack.max(NEAR) * (1.0 + value.abs())
}

/// The simplest constant within the slack of a number.
fn constant(pool: &mut Pool, value: f64, slack: f64) -> Option<Expr> {
    let simple = |x: f64, denominator: i64| -> Option<Rational> {
        let width = slack.max(NEAR) * (1.0 + x.abs());
        let (low, high) = (Rational::try_from(x - width).ok()?, Rational::try_from(x + width).ok()?);
        let zero = low < Rational::ZERO && high > Rational::ZERO;
        let q = if zero { Rational::ZERO } else { Rational::simplest_in(low, high) };
        (Rational::from(q.denominator().clone()) <= Rational::from(denominator)).then_some(q)
    };
    if let Some(q) = simple(value, DENOMINATORS[0]) {
        return Some(pool.rational(q));
    }
    if let Some(q) = simple(value / std::f64::consts::PI, 60) {
        let (q, pi) = (pool.rational(q), pool.pi());
        return Some(pool.mul(q, pi));
    }
    if let Some(q) = simple(value * value, DENOMINATORS[0]) {
        let square = pool.rational(q);
        let root = pool.sqrt(square);
        return Some(if value < 0.0 { pool.neg(root) } else { root });
    }
    simple(value, DENOMINATORS[1]).map(|q| pool.rational(q))
}
