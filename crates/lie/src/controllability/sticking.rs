//! Surfaces that bounded inputs do not leave, such as rest under dry friction.

use bracketry_symbolic::{Expr, Function, Pool, Rational};
use rustc_hash::FxHashMap;

use crate::algebra::span::vanishes;
use crate::controllability::meeting::{Adjacent, CLEAR, Ranges};
use crate::reason::StlcReason;

/// A surface onto which the modes on either side drive the motion, whatever the inputs in their ranges (Filippov 1988, § 18).
pub(crate) fn sticks(pool: &mut Pool, adjacent: &[Adjacent], ranges: &Ranges, everywhere: bool) -> Option<StlcReason> {
    let mut switches: Vec<usize> = adjacent.iter().flat_map(|a| a.switches.clone()).collect();
    switches.sort_unstable();
    switches.dedup();
    'switch: for i in switches {
        let mut function = None;
        for a in adjacent {
            let Some(place) = a.switches.iter().position(|&k| k == i) else { continue 'switch };
            let (s, sign) = a.vanishing[place];
            function.get_or_insert(s);
            let states = &a.fields.states;
            let drift = pool.lie_derivative(s, states, &a.fields.drift);
            let mut rates = vec![drift];
            for g in &a.fields.controls {
                rates.push(pool.lie_derivative(s, states, g));
            }
            // Away from the point the rates must be the same.
            let symbols = pool.symbols_of(&rates);
            if everywhere && states.iter().any(|x| symbols.contains(x)) {
                continue 'switch;
            }
            let same = !states.iter().any(|x| symbols.contains(x));
            if same && never_leaves(pool, a, sign, &rates, ranges) {
                continue;
            }
            let at: FxHashMap<Expr, Expr> =
                states.iter().zip(a.frame.point()).map(|(&s, &v)| (pool.sym(s), v)).collect();
            let at_point = pool.substitute_all(&rates, &at);
            let Some(values) = a.frame.numbers(pool, &at_point) else { continue 'switch };
            // The largest rate away from the surface.
            let sign = f64::from(sign);
            let mut away = sign * values[0];
            for (&g, &(lower, upper)) in values[1..].iter().zip(&ranges.ends) {
                if g != 0.0 {
                    away += (sign * g * lower).max(sign * g * upper);
                }
            }
            // An input without bounds counts near the point too, where its rate need not vanish.
            let unbounded = rates[1..].iter().zip(&ranges.ends).any(|(&e, &(lower, upper))| {
                let bounded = lower.is_finite() && upper.is_finite();
                !(bounded || vanishes(pool, e, &a.fields.bindings))
            });
            if unbounded || away.is_nan() || away >= -CLEAR * (1.0 + values[0].abs()) {
                continue 'switch;
            }
        }
        if let Some(function) = function {
            return Some(StlcReason::Sticks(Function::new(pool, function)));
        }
    }
    None
}

/// Whether a rate that is the same at all states leads away from the surface for no inputs in their ranges; 0 does not either.
fn never_leaves(pool: &mut Pool, a: &Adjacent, sign: i8, rates: &[Expr], ranges: &Ranges) -> bool {
    let Some(values) = a.frame.rationals(pool, rates) else { return false };
    let sign = Rational::from(sign);
    let mut away = &sign * &values[0];
    for (g, &(lower, upper)) in values[1..].iter().zip(&ranges.ends) {
        let slope = &sign * g;
        if slope == Rational::ZERO {
            continue;
        }
        let Some(end) = Rational::simplest_from_f64(if slope > Rational::ZERO { upper } else { lower }) else {
            return false;
        };
        away += slope * end;
    }
    away <= Rational::ZERO
}

/// A coordinate that rests on the `surface` σ = 0 in all modes: near the point the states on σ = 0 keep their value of it.
///
/// On the surface a coordinate y in which σ is affine is a function of the others.
pub(crate) fn frozen(pool: &mut Pool, adjacent: &[Adjacent], surface: &Function) -> Option<Function> {
    let first = adjacent.first()?;
    let (states, bindings) = (&first.fields.states, &first.fields.bindings);
    let sigma = *pool.import(&surface.pool().export(&[surface.expr()])).ok()?.first()?;
    let (solved, on_surface) = states.iter().find_map(|&y| {
        let slope = pool.diff(sigma, y);
        let slope = pool.simplify(slope);
        if pool.symbols_of(&[slope]).iter().any(|s| states.contains(s)) || vanishes(pool, slope, bindings) {
            return None;
        }
        let (zero, of_y) = (pool.int(0), pool.sym(y));
        let rest = pool.substitute(sigma, &std::iter::once((of_y, zero)).collect());
        let value = pool.div(rest, slope);
        let value = pool.neg(value);
        Some((y, std::iter::once((of_y, value)).collect::<FxHashMap<Expr, Expr>>()))
    })?;
    let rests = |pool: &mut Pool, i: usize| {
        adjacent.iter().all(|a| {
            let rates = a.fields.controls.iter().map(|g| g[i]).chain([a.frame.fields.drift[i]]);
            rates.collect::<Vec<_>>().into_iter().all(|e| {
                let there = pool.substitute(e, &on_surface);
                vanishes(pool, there, bindings)
            })
        })
    };
    let i = (0..states.len()).find(|&i| states[i] != solved && rests(pool, i))?;
    let kept = pool.sym(states[i]);
    Some(Function::new(pool, kept))
}
