//! Equations as sums of (function of states) · (function of inputs).

use std::collections::BTreeMap;

use bracketry_symbolic::{Bindings, Expr, Func, Function, Node, Pool, Symbol, ZeroTest};
use rustc_hash::FxHashSet;

use crate::input_change::{Change, rows};
use crate::reason::Rejection;
use crate::system::System;

/// Products of sums are multiplied out up to this many terms.
const MAX_TERMS: usize = 2000;

/// The terms of an expression as (factor free of inputs, factor of inputs only).
struct Separation<'a> {
    inputs: &'a FxHashSet<Symbol>,
    states: &'a FxHashSet<Symbol>,
}

impl Separation<'_> {
    /// `None` if some factor mixes states and inputs.
    fn terms(&self, pool: &mut Pool, e: Expr) -> Option<Vec<(Expr, Expr)>> {
        let uses = pool.symbols_of(&[e]);
        let has_input = uses.iter().any(|s| self.inputs.contains(s));
        let has_state = uses.iter().any(|s| self.states.contains(s));
        let one = pool.int(1);
        match (has_input, has_state) {
            (false, _) => return Some(vec![(e, one)]),
            (true, false) if !matches!(pool.node(e), Node::Add(..) | Node::Mul(..)) => return Some(vec![(one, e)]),
            _ => {}
        }
        match pool.node(e) {
            Node::Add(a, b) => {
                let mut left = self.terms(pool, a)?;
                left.extend(self.terms(pool, b)?);
                Some(left)
            }
            Node::Mul(a, b) => self.product(pool, a, b),
            Node::Pow(a, k) => {
                let k = pool.integer(k).filter(|k| k.unsigned_abs() <= 8)?;
                if let [(x, u)] = self.terms(pool, a)?[..] {
                    return Some(vec![(pool.powi(x, k), pool.powi(u, k))]);
                }
                if k < 2 {
                    return None;
                }
                let rest = pool.powi(a, k - 1);
                self.product(pool, a, rest)
            }
            Node::Call(f @ (Func::Exp | Func::Sin | Func::Cos), a) => {
                let (of_state, of_input) = self.split(pool, a)?;
                if f == Func::Exp {
                    return Some(vec![(pool.call(f, of_state), pool.call(f, of_input))]);
                }
                // sin(a + b) = cos a sin b + sin a cos b, cos(a + b) = cos a cos b − sin a sin b
                let (sx, cx) = (pool.sin(of_state), pool.cos(of_state));
                let (su, cu) = (pool.sin(of_input), pool.cos(of_input));
                if f == Func::Sin {
                    return Some(vec![(cx, su), (sx, cu)]);
                }
                let minus = pool.neg(sx);
                Some(vec![(cx, cu), (minus, su)])
            }
            _ => None,
        }
    }

    /// A sum as (terms free of inputs) + (terms free of states).
    fn split(&self, pool: &mut Pool, e: Expr) -> Option<(Expr, Expr)> {
        let (mut of_state, mut of_input) = (pool.int(0), pool.int(0));
        for (x, u) in self.terms(pool, e)? {
            let uses = pool.symbols_of(&[x]);
            if pool.is_one(u) {
                of_state = pool.add(of_state, x);
            } else if uses.iter().any(|s| self.states.contains(s)) {
                return None;
            } else {
                let term = pool.mul(x, u);
                of_input = pool.add(of_input, term);
            }
        }
        Some((of_state, of_input))
    }

    fn product(&self, pool: &mut Pool, a: Expr, b: Expr) -> Option<Vec<(Expr, Expr)>> {
        let left = self.terms(pool, a)?;
        let right = self.terms(pool, b)?;
        if left.len() * right.len() > MAX_TERMS {
            return None;
        }
        let mut out = Vec::with_capacity(left.len() * right.len());
        for &(x, u) in &left {
            for &(y, w) in &right {
                out.push((pool.mul(x, y), pool.mul(u, w)));
            }
        }
        Some(out)
    }

    /// Splits a product into its factors with states and those without.
    fn coefficient(&self, pool: &mut Pool, e: Expr) -> (Expr, Expr) {
        let (mut constant, mut of_state) = (pool.int(1), pool.int(1));
        for f in crate::images::flattened(pool, e, false) {
            if pool.symbols_of(&[f]).iter().any(|s| self.states.contains(s)) {
                of_state = pool.mul(of_state, f);
            } else {
                constant = pool.mul(constant, f);
            }
        }
        (constant, of_state)
    }
}

/// One row for each pair (equation, factor of states): its combination of functions of inputs.
struct Combination {
    row: usize,
    factor: Expr,
    /// Constant coefficient of each function of inputs, by column.
    coefficients: Vec<Expr>,
}

/// Numbers and parameters: zero as far as the exact test sees, where undecided as it is written.
fn vanishes(pool: &mut Pool, e: Expr) -> bool {
    pool.is_zero(e)
        || (pool.number(e).is_none() && matches!(pool.zero_test(e, &Bindings::default()), ZeroTest::Zero(_)))
}

/// Reduced row echelon form; returns the pivot columns of the rows that are left.
fn reduce(pool: &mut Pool, rows: &mut Vec<Vec<Expr>>) -> Vec<usize> {
    let mut pivots = Vec::new();
    let columns = rows.first().map_or(0, Vec::len);
    for j in 0..columns {
        let done = pivots.len();
        let Some(i) = (done..rows.len()).find(|&i| !vanishes(pool, rows[i][j])) else { continue };
        rows.swap(done, i);
        pool.eliminate_column(rows, (done, j), Pool::simplify);
        pivots.push(j);
    }
    rows.truncate(pivots.len());
    pivots
}

/// Multiplies each row of several terms so that it reads as it does in the equations, apart from a common whole factor;
/// returns the new pivots.
fn scales(pool: &mut Pool, basis: &mut [Vec<Expr>], pivots: &[usize], combinations: &[Combination]) -> Vec<Expr> {
    let mut scales = Vec::new();
    for (row, &j) in basis.iter_mut().zip(pivots) {
        let one = pool.int(1);
        scales.push(one);
        if row.iter().filter(|e| !pool.is_zero(**e)).count() < 2 {
            continue;
        }
        for c in combinations {
            let scale = c.coefficients[j];
            if vanishes(pool, scale) {
                continue;
            }
            let multiple: Vec<Expr> = row.iter().map(|&e| pool.mul(scale, e)).collect();
            let same = multiple.iter().zip(&c.coefficients).all(|(&a, &b)| {
                let d = pool.sub(a, b);
                vanishes(pool, d)
            });
            if !same {
                continue;
            }
            let whole = c.coefficients.iter().map(|&e| pool.integer(e)).collect::<Option<Vec<i64>>>();
            let factor = whole.map_or(1, |w| w.into_iter().fold(0, |g, k| gcd(g, k.unsigned_abs()))).max(1);
            let sign = if pool.integer(scale).is_some_and(|k| k < 0) { -1 } else { 1 };
            let factor = pool.int(sign * i64::try_from(factor).unwrap_or(1));
            *row = c.coefficients.iter().map(|&e| pool.div(e, factor)).collect();
            if let Some(last) = scales.last_mut() {
                *last = pool.div(scale, factor);
            }
            break;
        }
    }
    scales
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// A change to new inputs w(u), if the equations are sums of functions of states times functions of inputs, and these
/// span, over the constants, a space of at most as many functions as there are inputs.
///
/// The basis is in reduced echelon form, so that each function has as few terms as the space permits.
pub(crate) fn separated(system: &mut System) -> Result<Change, Rejection> {
    let inputs: FxHashSet<Symbol> = system.inputs.iter().copied().collect();
    let states: FxHashSet<Symbol> = system.states.iter().copied().collect();
    let separation = Separation { inputs: &inputs, states: &states };
    let all = rows(system);
    let most = system.inputs.len();
    let pool = &mut system.pool;
    let mut rest = vec![pool.int(0); all.len()];
    let mut monomials: Vec<Expr> = Vec::new();
    let mut sparse: BTreeMap<(usize, Expr), BTreeMap<usize, Expr>> = BTreeMap::new();
    for (row, &e) in all.iter().enumerate() {
        let terms = separation.terms(pool, e);
        let mixed = || Rejection::Mixed(Function::new(pool, e));
        for (x, u) in terms.ok_or_else(mixed)? {
            let (cu, w) = separation.input_coefficient(pool, u);
            let x = pool.mul(x, cu);
            if pool.is_one(w) {
                rest[row] = pool.add(rest[row], x);
                continue;
            }
            let (constant, factor) = separation.coefficient(pool, x);
            let column = monomials.iter().position(|&m| m == w).unwrap_or_else(|| {
                monomials.push(w);
                monomials.len() - 1
            });
            let zero = pool.int(0);
            let entry = sparse.entry((row, factor)).or_default().entry(column).or_insert(zero);
            *entry = pool.add(*entry, constant);
        }
    }
    let zero = pool.int(0);
    let combinations: Vec<Combination> = sparse
        .into_iter()
        .map(|((row, factor), c)| {
            let coefficients = (0..monomials.len()).map(|k| c.get(&k).copied().unwrap_or(zero)).collect();
            Combination { row, factor, coefficients }
        })
        .collect();
    let mut basis: Vec<Vec<Expr>> = combinations.iter().map(|c| c.coefficients.clone()).collect();
    let pivots = reduce(pool, &mut basis);
    if basis.len() > most || basis.is_empty() {
        return Err(Rejection::TooMany { functions: basis.len(), inputs: most });
    }
    let scales = scales(pool, &mut basis, &pivots, &combinations);
    let functions: Vec<Expr> = basis
        .iter()
        .map(|row| {
            let terms: Vec<Expr> = row.iter().zip(&monomials).map(|(&c, &m)| pool.mul(c, m)).collect();
            let sum = pool.sum(terms);
            pool.simplify(sum)
        })
        .collect();
    // A row of the echelon form has its scale in its pivot column, where all others have 0: weights are read off there.
    let mut factors = vec![vec![zero; functions.len()]; all.len()];
    for c in &combinations {
        for (k, &j) in pivots.iter().enumerate() {
            let weight = pool.div(c.coefficients[j], scales[k]);
            let term = pool.mul(weight, c.factor);
            factors[c.row][k] = pool.add(factors[c.row][k], term);
        }
    }
    Ok(Change { functions, rest, factors })
}

impl Separation<'_> {
    /// Splits the factors without inputs off a function of inputs.
    fn input_coefficient(&self, pool: &mut Pool, e: Expr) -> (Expr, Expr) {
        let (mut constant, mut of_input) = (pool.int(1), pool.int(1));
        for f in crate::images::flattened(pool, e, false) {
            if pool.symbols_of(&[f]).iter().any(|s| self.inputs.contains(s)) {
                of_input = pool.mul(of_input, f);
            } else {
                constant = pool.mul(constant, f);
            }
        }
        (constant, of_input)
    }
}
