//! New inputs v = w(x, u), found by the rank condition that decides whether there are any.

use bracketry_symbolic::{Bindings, Expr, Pool, Rational, Symbol};
use rustc_hash::FxHashMap;

use crate::images::flattened;
use crate::input_change::{Change, Checks, canonical, rows, without_switches};
use crate::reason::Rejection;
use crate::switching::is_switch;
use crate::system::System;

/// More functions than this are not solved for.
const MAX_FUNCTIONS: usize = 8;

/// Most new nodes of the pool in the inverse of a matrix.
const MAX_NODES: usize = 50_000;

/// A change v = w(x, u) after which the equations are affine in v, if there is one.
///
/// Let r be the generic rank of ∂f/∂u, and take r rows of it and r columns C that are independent. If f = a(x) + B(x)
/// w(x, u) with independent w_1 … w_r, every row of f is a function of x plus a combination, with coefficients M(x), of
/// the chosen rows f_R; then M = ∂f/∂u_C (∂f_R/∂u_C)⁻¹ does not depend on u and may be taken at any u_0, and w = f_R
/// does. So the change exists if and only if f − M f_R, with M taken at u_0, is free of u. (The affine hull of the
/// velocities f(x, ·) then has dimension r.)
pub(crate) fn by_rows(system: &mut System) -> Result<Change, Rejection> {
    let inputs = system.inputs.clone();
    let all = rows(system);
    if system.pool.reachable(&all).into_iter().any(|n| is_switch_of(&system.pool, n, &inputs)) {
        return Err(Rejection::SwitchOfInput);
    }
    let (probe, smooth) = without_switches(system, &all);
    let mut probe_pool = probe.pool;
    // Short rows first, so that the functions become short.
    let mut order: Vec<usize> = (0..all.len()).collect();
    order.sort_by_key(|&i| (system.pool.reachable(&[all[i]]).len(), i));
    let jacobian: Vec<Vec<Expr>> = order.iter().map(|&i| probe_pool.gradient(smooth[i], &inputs)).collect();
    let ranked = probe_pool.rank(&jacobian, &Bindings::default())?;
    let r = ranked.rank;
    if r == 0 || r > MAX_FUNCTIONS {
        return Err(Rejection::Unsolved { functions: r });
    }
    if directions_vary(&mut probe_pool, &jacobian, &inputs, r)? {
        return Err(Rejection::DirectionsVary { directions: r });
    }
    let chosen: Vec<usize> = ranked.independent.iter().map(|&k| order[k]).collect();
    let transposed: Vec<Vec<Expr>> =
        (0..inputs.len()).map(|j| ranked.independent.iter().map(|&k| jacobian[k][j]).collect()).collect();
    let columns: Vec<Symbol> =
        probe_pool.rank(&transposed, &Bindings::default())?.independent.iter().map(|&j| inputs[j]).collect();

    let pool = &mut system.pool;
    let full: Vec<Vec<Expr>> = all.iter().map(|&e| pool.gradient(e, &columns)).collect();
    let Some(RegularValue { at, inverse }) = regular_value(pool, &full, &chosen, &inputs) else {
        return Err(Rejection::NoRegularValue);
    };
    let mut rest = Vec::new();
    let mut functions = Vec::new();
    for &i in &chosen {
        let (without, with) = parts(pool, all[i], &inputs);
        functions.push(with);
        rest.push((i, without));
    }
    let here = pool.substitute_all(&functions, &at);
    let mut change = Change { functions, rest: Vec::new(), factors: Vec::new() };
    for (row, &e) in all.iter().enumerate() {
        if let Some(k) = chosen.iter().position(|&i| i == row) {
            change.rest.push(rest[k].1);
            let unit = (0..r).map(|j| pool.int(i64::from(j == k))).collect();
            change.factors.push(unit);
            continue;
        }
        let slopes = pool.substitute_all(&full[row], &at);
        let mut a = pool.substitute(e, &at);
        let mut b = Vec::with_capacity(r);
        for (j, &w) in here.iter().enumerate() {
            let mut m = pool.int(0);
            for (l, &s) in slopes.iter().enumerate() {
                let term = pool.mul(s, inverse[l][j]);
                m = pool.add(m, term);
            }
            let m = pool.simplify(m);
            let used = pool.mul(m, w);
            a = pool.sub(a, used);
            b.push(m);
        }
        change.rest.push(pool.simplify(a));
        change.factors.push(b);
    }
    verify(system, &all, &change)?;
    Ok(change)
}

/// Whether the columns of ∂f/∂u at two values of u span more than those at one.
fn directions_vary(pool: &mut Pool, jacobian: &[Vec<Expr>], inputs: &[Symbol], rank: usize) -> Result<bool, Rejection> {
    let mut other = FxHashMap::default();
    for &u in inputs {
        let name = format!("another {}", pool.name(u));
        let (u, v) = (pool.sym(u), pool.var(&name));
        other.insert(u, v);
    }
    let mut both = Vec::with_capacity(jacobian.len());
    for row in jacobian {
        let there = pool.substitute_all(row, &other);
        both.push(row.iter().copied().chain(there).collect::<Vec<Expr>>());
    }
    Ok(pool.rank(&both, &Bindings::default())?.rank > rank)
}

fn is_switch_of(pool: &Pool, n: Expr, inputs: &[Symbol]) -> bool {
    is_switch(pool.node(n)) && inputs.iter().any(|&u| pool.depends_on(n, u))
}

/// Whether f = a + B w.
fn verify(system: &System, all: &[Expr], change: &Change) -> Result<(), Rejection> {
    let mut check = system.clone();
    let mut differences = Vec::new();
    for ((&e, &a), b) in all.iter().zip(&change.rest).zip(&change.factors) {
        let mut d = check.pool.sub(e, a);
        for (&b, &w) in b.iter().zip(&change.functions) {
            let term = check.pool.mul(b, w);
            d = check.pool.sub(d, term);
        }
        differences.push(d);
    }
    let differences = canonical(&mut check.pool, differences);
    let (mut check, smooth) = without_switches(&check, &differences);
    let mut checks = Checks::default();
    for d in smooth {
        if !checks.is_zero(&mut check.pool, d)? {
            return Err(Rejection::DirectionsVary { directions: change.functions.len() });
        }
    }
    Ok(())
}

/// The terms of a sum that are free of inputs, and the others.
fn parts(pool: &mut Pool, e: Expr, inputs: &[Symbol]) -> (Expr, Expr) {
    let terms = flattened(pool, e, true);
    let (with, without): (Vec<Expr>, Vec<Expr>) =
        terms.into_iter().partition(|&t| pool.symbols_of(&[t]).iter().any(|s| inputs.contains(s)));
    (pool.sum(without), pool.sum(with))
}

/// Values of the inputs at which the chosen rows are independent, and the inverse of these rows there.
struct RegularValue {
    at: FxHashMap<Expr, Expr>,
    inverse: Vec<Vec<Expr>>,
}

/// Values of the inputs at which the chosen rows are independent, and the inverse of these rows there.
fn regular_value(pool: &mut Pool, jacobian: &[Vec<Expr>], chosen: &[usize], inputs: &[Symbol]) -> Option<RegularValue> {
    let patterns: [fn(i64) -> Rational; 4] =
        [|_| Rational::ZERO, |_| Rational::ONE, |j| Rational::from(j + 1), |j| Rational::ONE / Rational::from(j + 2)];
    for value in patterns {
        let mut at = FxHashMap::default();
        for (j, &u) in inputs.iter().enumerate() {
            let (u, v) = (pool.sym(u), pool.rational(value(j as i64)));
            at.insert(u, v);
        }
        let rows: Vec<Vec<Expr>> = chosen.iter().map(|&i| pool.substitute_all(&jacobian[i], &at)).collect();
        let regular = pool.rank(&rows, &Bindings::default()).is_ok_and(|k| k.rank == chosen.len());
        let finite = |pool: &mut Pool| {
            let everything: Vec<Expr> = jacobian.iter().flatten().copied().collect();
            let here = pool.substitute_all(&everything, &at);
            pool.rank(&[here], &Bindings::default()).is_ok()
        };
        if regular
            && finite(pool)
            && let Some(inverse) = inverted(pool, &rows)
        {
            return Some(RegularValue { at, inverse });
        }
    }
    None
}

/// The inverse by elimination.
fn inverted(pool: &mut Pool, rows: &[Vec<Expr>]) -> Option<Vec<Vec<Expr>>> {
    let (n, first) = (rows.len(), pool.len());
    let mut m: Vec<Vec<Expr>> = Vec::with_capacity(n);
    for (i, row) in rows.iter().enumerate() {
        let unit: Vec<Expr> = (0..n).map(|j| pool.int(i64::from(i == j))).collect();
        m.push(row.iter().copied().chain(unit).collect());
    }
    for j in 0..n {
        if pool.len() > first + MAX_NODES {
            return None;
        }
        let mut pivot = None;
        for (i, row) in m.iter().enumerate().skip(j) {
            if !pool.is_zero(row[j]) && pool.zero_test(row[j], &Bindings::default()).is_nonzero() {
                pivot = Some(i);
                break;
            }
        }
        m.swap(j, pivot?);
        pool.eliminate_column(&mut m, (j, j), Pool::simplify);
    }
    Some(m.into_iter().map(|row| row[n..].to_vec()).collect())
}
