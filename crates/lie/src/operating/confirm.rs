//! Exact values of a numerical solution.

use bracketry_symbolic::{Bindings, Expr, Pool, Rational, Symbol, Tape};
use rustc_hash::FxHashMap;

/// How near a number has to be to a simple constant that is tried.
const NEAR: f64 = 1e-8;

/// Largest denominators of constants that are tried, the simplest kind first.
const DENOMINATORS: [i64; 2] = [1000, 100_000];

/// Most guesses that are tried.
const MAX_GUESSES: usize = 200;

/// Values of the free variables at which the equations, with parameters at their values, vanish exactly. Variables that an
/// equation determines linearly are solved for; others are guessed as rational numbers, multiples of π, and square roots.
/// `None` where no guess is confirmed.
pub(crate) fn confirmed(
    pool: &mut Pool,
    equations: &[Expr],
    free: &[Symbol],
    z: &[f64],
    slack: f64,
) -> Option<Vec<Expr>> {
    let mut guesses = Guesses { free, z, slack, left: MAX_GUESSES };
    guesses.complete(pool, equations, vec![None; free.len()])
}

struct Guesses<'a> {
    free: &'a [Symbol],
    z: &'a [f64],
    slack: f64,
    /// Guesses that may still be tried.
    left: usize,
}

impl Guesses<'_> {
    /// The values, with those that are known, at which the equations vanish.
    fn complete(&mut self, pool: &mut Pool, equations: &[Expr], known: Vec<Option<Expr>>) -> Option<Vec<Expr>> {
        let is_open = |s: &Symbol| self.free.iter().zip(&known).any(|(f, v)| f == s && v.is_none());
        for &e in equations {
            if !pool.symbols_of(&[e]).iter().any(is_open) {
                let e = pool.simplify(e);
                if !pool.is_zero(e) && !pool.zero_test(e, &Bindings::default()).is_zero() {
                    return None;
                }
            }
        }
        let open: Vec<usize> = (0..known.len()).filter(|&k| known[k].is_none()).collect();
        if open.is_empty() {
            return known.into_iter().collect();
        }
        let solved = equations.iter().find_map(|&e| {
            let uses = pool.symbols_of(&[e]);
            let mut unknown = open.iter().copied().filter(|&k| uses.contains(&self.free[k]));
            let (Some(k), None) = (unknown.next(), unknown.next()) else { return None };
            let value = linear_root(pool, e, self.free[k])?;
            near(pool, value, self.z[k], self.slack).then_some((k, value))
        });
        let (k, values) = match solved {
            Some((k, value)) => (k, vec![value]),
            None => open.iter().find_map(|&k| {
                let list = constants(pool, self.z[k], self.slack);
                (!list.is_empty()).then_some((k, list))
            })?,
        };
        for value in values {
            self.left = self.left.checked_sub(1)?;
            let variable = pool.sym(self.free[k]);
            let rest = pool.substitute_all(equations, &std::iter::once((variable, value)).collect());
            let mut with = known.clone();
            with[k] = Some(value);
            if let Some(found) = self.complete(pool, &rest, with) {
                return Some(found);
            }
        }
        None
    }
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

/// The simplest constants of several kinds near a number, within narrow limits first: a multiple solution is found to half of its digits or
/// fewer.
fn constants(pool: &mut Pool, value: f64, slack: f64) -> Vec<Expr> {
    let simple = |x: f64, width: f64, denominator: i64| -> Option<Rational> {
        let width = width * (1.0 + x.abs());
        let (low, high) = (Rational::try_from(x - width).ok()?, Rational::try_from(x + width).ok()?);
        let zero = low < Rational::ZERO && high > Rational::ZERO;
        let q = if zero { Rational::ZERO } else { Rational::simplest_in(low, high) };
        (Rational::from(q.denominator().clone()) <= Rational::from(denominator)).then_some(q)
    };
    let mut list: Vec<Expr> = Vec::new();
    for width in [NEAR, NEAR.sqrt(), slack].into_iter().filter(|w| *w <= slack.max(NEAR)) {
        if let Some(q) = simple(value, width, DENOMINATORS[0]) {
            list.push(pool.rational(q));
        }
        if let Some(q) = simple(value / std::f64::consts::PI, width, 60).filter(|q| *q != Rational::ZERO) {
            let (q, pi) = (pool.rational(q), pool.pi());
            list.push(pool.mul(q, pi));
        }
        if let Some(q) = simple(value * value, width, DENOMINATORS[0]).filter(|q| *q > Rational::ZERO) {
            let square = pool.rational(q);
            let root = pool.sqrt(square);
            list.push(if value < 0.0 { pool.neg(root) } else { root });
        }
        list.extend(simple(value, width, DENOMINATORS[1]).map(|q| pool.rational(q)));
    }
    let mut seen = Vec::new();
    list.retain(|e| {
        let new = !seen.contains(e);
        seen.push(*e);
        new
    });
    list
}
