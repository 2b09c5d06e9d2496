//! Coordinate changes solved for the old coordinates.

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Symbol};
use bracketry_system::solved_for;
use rustc_hash::FxHashMap;

use crate::algebra::matrix::solve;
use crate::algebra::rational::readable::tidy;
use crate::algebra::span::vanishes;

/// New symbols z1, z2, … and the states as functions of them, where z = T(x) is solved in closed form; with T(x(z)) = z
/// verified exactly.
///
/// Equations with a single unknown state are solved one after the other; two that are affine in the same two states, together.
pub(crate) fn inverse(
    pool: &mut Pool,
    states: &[Symbol],
    coordinates: &[Expr],
    bindings: &Bindings,
) -> (Vec<Symbol>, Option<Vec<Expr>>) {
    let symbols = fresh(pool, states, coordinates, bindings);
    let mut known: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut open: Vec<usize> = (0..coordinates.len()).collect();
    while !open.is_empty() {
        let Some((used, found)) = step(pool, states, coordinates, &symbols, &open, &known) else {
            return (symbols, None);
        };
        open.retain(|k| !used.contains(k));
        known.extend(found);
    }
    let mut values = Vec::new();
    for &s in states {
        let x = pool.sym(s);
        let Some(&e) = known.get(&x) else { return (symbols, None) };
        values.push(e);
    }
    for (&z, &s) in coordinates.iter().zip(&symbols) {
        let (back, new) = (pool.substitute(z, &known), pool.sym(s));
        let difference = pool.sub(back, new);
        if !vanishes(pool, difference, bindings) {
            return (symbols, None);
        }
    }
    (symbols, Some(values))
}

/// Symbols z1, z2, …, with underscores where the system has such names.
fn fresh(pool: &mut Pool, states: &[Symbol], coordinates: &[Expr], bindings: &Bindings) -> Vec<Symbol> {
    let mut taken = pool.symbols_of(coordinates);
    taken.extend(states);
    let mut symbols = Vec::new();
    for k in 1..=coordinates.len() {
        let mut name = format!("z{k}");
        let mut s = pool.symbol(&name);
        while taken.contains(&s) || bindings.get(s).is_some() {
            name.push('_');
            s = pool.symbol(&name);
        }
        symbols.push(s);
    }
    symbols
}

type Solved = (Vec<usize>, Vec<(Expr, Expr)>);

/// One equation solved for its only unknown state, or two for two.
fn step(
    pool: &mut Pool,
    states: &[Symbol],
    coordinates: &[Expr],
    symbols: &[Symbol],
    open: &[usize],
    known: &FxHashMap<Expr, Expr>,
) -> Option<Solved> {
    let equations: Vec<(usize, Expr, Vec<Symbol>)> = open
        .iter()
        .map(|&k| {
            let e = pool.substitute(coordinates[k], known);
            let uses = pool.symbols_of(&[e]);
            (k, e, states.iter().copied().filter(|s| uses.contains(s)).collect())
        })
        .collect();
    for (k, e, unknown) in &equations {
        if let [s] = unknown[..] {
            let z = pool.sym(symbols[*k]);
            let value = solved_for(pool, *e, s, z).or_else(|| by_tangent(pool, *e, s, z));
            if let Some(value) = value {
                let x = pool.sym(s);
                return Some((vec![*k], vec![(x, tidy(pool, value))]));
            }
        }
    }
    for (i, (k, e, unknown)) in equations.iter().enumerate() {
        for (l, f, others) in &equations[i + 1..] {
            if unknown.len() != 2 || unknown != others {
                continue;
            }
            let Some(values) = affine_pair(pool, [*e, *f], unknown, [symbols[*k], symbols[*l]]) else { continue };
            let found = unknown.iter().zip(values).map(|(&s, v)| (pool.sym(s), v)).collect();
            return Some((vec![*k, *l], found));
        }
    }
    None
}

/// The solution of an equation in which sine and cosine of one angle occur as their quotient: the angle is an arc tangent, with
/// values from −π/2 to π/2.
fn by_tangent(pool: &mut Pool, e: Expr, unknown: Symbol, right: Expr) -> Option<Expr> {
    let mut angle = None;
    for node in pool.reachable(&[e]) {
        let Node::Call(Func::Sin | Func::Cos, a) = pool.node(node) else { continue };
        if pool.depends_on(a, unknown) && angle.is_some_and(|other| other != a) {
            return None;
        }
        if pool.depends_on(a, unknown) {
            angle = Some(a);
        }
    }
    let angle = angle?;
    // No model can use these names.
    let (tangent, cosine) = (pool.symbol("the tangent"), pool.symbol("the cosine"));
    let (t, c) = (pool.sym(tangent), pool.sym(cosine));
    let (sin, cos, product) = (pool.sin(angle), pool.cos(angle), pool.mul(t, c));
    let quotient = pool.substitute(e, &[(sin, product), (cos, c)].into_iter().collect());
    let quotient = tidy(pool, quotient);
    if pool.depends_on(quotient, cosine) || pool.depends_on(quotient, unknown) {
        return None;
    }
    let value = solved_for(pool, quotient, tangent, right)?;
    let value = pool.call(Func::Atan, value);
    solved_for(pool, angle, unknown, value)
}

/// Two equations that are affine in two unknowns.
fn affine_pair(pool: &mut Pool, equations: [Expr; 2], unknown: &[Symbol], right: [Symbol; 2]) -> Option<Vec<Expr>> {
    let zero = pool.int(0);
    let at_zero: FxHashMap<Expr, Expr> = unknown.iter().map(|&s| (pool.sym(s), zero)).collect();
    let (mut rows, mut sides) = (Vec::new(), Vec::new());
    for (e, z) in equations.into_iter().zip(right) {
        let row: Vec<Expr> = unknown
            .iter()
            .map(|&s| {
                let d = pool.diff(e, s);
                tidy(pool, d)
            })
            .collect();
        if unknown.iter().any(|&s| row.iter().any(|&d| pool.depends_on(d, s))) {
            return None;
        }
        let (rest, z) = (pool.substitute(e, &at_zero), pool.sym(z));
        sides.push(pool.sub(z, rest));
        rows.push(row);
    }
    solve(pool, &rows, &sides)
}
