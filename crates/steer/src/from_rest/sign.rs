//! Whether a function is nowhere negative on a box.

use std::cmp::Ordering;

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol};
use bracketry_system::LeastValue;
use rustc_hash::FxHashMap;
use serde::Serialize;

use super::bounds::Span;

/// An answer on all admissible inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Holds {
    /// For all of them.
    Always,
    /// Not for some.
    NotAlways,
    /// Not decided.
    Undecided,
}

/// A least value below minus this is negative whatever the rounding of the ends of intervals.
const CLEAR: f64 = 1e-9;
/// Most variables of a function whose corners are all looked at.
const MAX_CORNER_VARIABLES: usize = 8;

/// Whether an expression is nowhere negative: by its least value with outward rounding, and where that is zero to rounding, by
/// exact values at corners.
pub(crate) fn nonnegative(pool: &mut Pool, e: Expr, symbols: &[(Symbol, Span)]) -> Holds {
    // What has one exact value is put in, so that the rest is decided over fewer numbers.
    let mut known: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (s, span) in symbols {
        if let [Some(a), Some(b)] = &span.exact
            && a == b
        {
            known.insert(pool.sym(*s), pool.rational(a.clone()));
        }
    }
    let e = pool.substitute(e, &known);
    let e = pool.simplify(e);
    let open: Vec<(Symbol, &Span)> =
        symbols.iter().filter(|(s, _)| pool.depends_on(e, *s)).map(|(s, span)| (*s, span)).collect();
    if open.is_empty() {
        return of_sign(pool.constant_sign(e, &Bindings::new()));
    }
    if open.iter().any(|(_, span)| !span.is_finite()) {
        return Holds::Undecided;
    }
    let (variables, region) = outward(&open);
    let Some(least) = LeastValue::on_box(pool, e, &variables, &region) else { return Holds::Undecided };
    if least.value >= 0.0 {
        return Holds::Always;
    }
    let exact = match least.corner {
        Some(corner) => at_corner(pool, e, &open, &corner),
        None if least.value >= -CLEAR && is_concave(pool, e, &open) => at_corners(pool, e, &open),
        None => None,
    };
    match exact {
        Some(sign) => of_sign(Some(sign)),
        None if least.value < -CLEAR => Holds::NotAlways,
        None => Holds::Undecided,
    }
}

fn of_sign(sign: Option<Ordering>) -> Holds {
    match sign {
        Some(Ordering::Less) => Holds::NotAlways,
        Some(_) => Holds::Always,
        None => Holds::Undecided,
    }
}

/// Variables with floating-point intervals that enclose theirs.
fn outward(open: &[(Symbol, &Span)]) -> (Vec<Symbol>, Vec<[f64; 2]>) {
    open.iter().map(|(s, span)| (*s, span.outward())).unzip()
}

/// The sign at a corner.
fn at_corner(pool: &mut Pool, e: Expr, open: &[(Symbol, &Span)], corner: &[bool]) -> Option<Ordering> {
    let mut ends: FxHashMap<Expr, Expr> = FxHashMap::default();
    for ((s, span), &upper) in open.iter().zip(corner) {
        let exact = span.exact[usize::from(upper)].clone()?;
        ends.insert(pool.sym(*s), pool.rational(exact));
    }
    let value = pool.substitute(e, &ends);
    pool.constant_sign(value, &Bindings::new())
}

/// The least sign at all corners, where the least value of a function is that is concave in every variable.
fn at_corners(pool: &mut Pool, e: Expr, open: &[(Symbol, &Span)]) -> Option<Ordering> {
    if open.len() > MAX_CORNER_VARIABLES {
        return None;
    }
    let corners = (0..1usize << open.len()).map(|bits| (0..open.len()).map(|k| bits >> k & 1 == 1).collect());
    let signs: Option<Vec<Ordering>> = corners.map(|corner: Vec<bool>| at_corner(pool, e, open, &corner)).collect();
    signs?.into_iter().min()
}

/// Whether a function is concave in every variable on the box.
fn is_concave(pool: &mut Pool, e: Expr, open: &[(Symbol, &Span)]) -> bool {
    let (variables, region) = outward(open);
    variables.iter().all(|&s| {
        let slope = pool.diff(e, s);
        let curvature = pool.diff(slope, s);
        let opposite = pool.neg(curvature);
        let opposite = pool.simplify(opposite);
        LeastValue::on_box(pool, opposite, &variables, &region).is_some_and(|least| least.value >= 0.0)
    })
}
