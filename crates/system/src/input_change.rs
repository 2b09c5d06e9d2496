//! New inputs v = w(u) for systems that depend on u through few functions.

use std::collections::BTreeMap;

use bracketry_symbolic::{Bindings, Expr, Func, Node, Pool, Rational, Symbol, Undecided};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::affine::{Affinization, Method, NewInput, fresh, is_zero};
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
                let k = pool.integer(k).filter(|k| (2..=8).contains(k))?;
                let rest = pool.powi(a, k - 1);
                self.product(pool, a, rest)
            }
            _ => None,
        }
    }

    fn product(&self, pool: &mut Pool, a: Expr, b: Expr) -> Option<Vec<(Expr, Expr)>> {
        let left = self.terms(pool, a)?;
        let right = self.terms(pool, b)?;
        if left.len() * right.len() > MAX_TERMS {
            return None;
        }
        let mut out = Vec::with_capacity(left.len() * right.len());
        for &(p, q) in &left {
            for &(r, s) in &right {
                out.push((pool.mul(p, r), pool.mul(q, s)));
            }
        }
        Some(out)
    }
}

/// The right-hand side as drift + Σ factor · (combination of input monomials), one entry per row and state factor.
struct Combinations {
    drift: Vec<Expr>,
    monomials: Vec<Expr>,
    /// (row, state factor, coefficient of each monomial)
    entries: Vec<(usize, Expr, Vec<Rational>)>,
}

fn combinations(system: &mut System) -> Option<Combinations> {
    let inputs: FxHashSet<Symbol> = system.inputs.iter().copied().collect();
    let states: FxHashSet<Symbol> = system.states.iter().copied().collect();
    let separation = Separation { inputs: &inputs, states: &states };
    let pool = &mut system.pool;
    let mut drift = vec![pool.int(0); system.states.len()];
    let mut monomials: Vec<Expr> = Vec::new();
    let mut sparse: Vec<(usize, Expr, BTreeMap<usize, Rational>)> = Vec::new();
    for (row, &e) in system.dynamics.iter().enumerate() {
        for (x, u) in separation.terms(pool, e)? {
            let (cu, w) = coefficient(pool, u);
            let (cx, factor) = coefficient(pool, x);
            if pool.is_one(w) {
                let term = pool.mul(x, u);
                drift[row] = pool.add(drift[row], term);
                continue;
            }
            let column = monomials.iter().position(|&m| m == w).unwrap_or_else(|| {
                monomials.push(w);
                monomials.len() - 1
            });
            let at = sparse.iter().position(|e| e.0 == row && e.1 == factor).unwrap_or_else(|| {
                sparse.push((row, factor, BTreeMap::new()));
                sparse.len() - 1
            });
            *sparse[at].2.entry(column).or_insert(Rational::ZERO) += cx * cu;
        }
    }
    let dense = |c: &BTreeMap<usize, Rational>| {
        (0..monomials.len()).map(|k| c.get(&k).cloned().unwrap_or(Rational::ZERO)).collect()
    };
    let entries = sparse.iter().map(|(row, factor, c)| (*row, *factor, dense(c))).collect();
    Some(Combinations { drift, monomials, entries })
}

/// Splits a numeric coefficient off a product.
fn coefficient(pool: &mut Pool, e: Expr) -> (Rational, Expr) {
    if let Some(c) = pool.number(e).cloned() {
        return (c, pool.int(1));
    }
    match pool.node(e) {
        Node::Mul(a, b) => match pool.number(a) {
            Some(c) => (c.clone(), b),
            None => (Rational::ONE, e),
        },
        _ => (Rational::ONE, e),
    }
}

/// The α with Σ α_j basis_j = row, if there are any; the basis is independent.
fn express(basis: &[Vec<Rational>], row: &[Rational]) -> Option<Vec<Rational>> {
    let k = basis.len();
    // One equation per monomial: Σ_j basis[j][i] α_j = row[i].
    let mut equations: Vec<Vec<Rational>> = (0..row.len())
        .map(|i| basis.iter().map(|b| b[i].clone()).chain(std::iter::once(row[i].clone())).collect())
        .collect();
    for j in 0..k {
        let pivot = (j..equations.len()).find(|&i| equations[i][j] != Rational::ZERO)?;
        equations.swap(j, pivot);
        let scale = equations[j][j].clone();
        for v in &mut equations[j] {
            *v = v.clone() / scale.clone();
        }
        let leading = equations[j].clone();
        for (i, other) in equations.iter_mut().enumerate() {
            if i != j && other[j] != Rational::ZERO {
                let factor = other[j].clone();
                for (v, l) in other.iter_mut().zip(&leading) {
                    *v = v.clone() - factor.clone() * l.clone();
                }
            }
        }
    }
    if equations[k..].iter().any(|e| e[k] != Rational::ZERO) {
        return None;
    }
    Some(equations[..k].iter().map(|e| e[k].clone()).collect())
}

/// New inputs v = w(u), if the equations depend on u through at most as many functions as there are inputs and these are
/// independent. Checked by putting w(u) back.
pub(crate) fn input_change(original: &System) -> Result<Option<Affinization>, Undecided> {
    let mut system = original.clone();
    let Some(mut parts) = combinations(&mut system) else { return Ok(None) };
    // Short combinations first, so that an input that enters as it is becomes a function of its own.
    parts.entries.sort_by_key(|e| e.2.iter().filter(|c| **c != Rational::ZERO).count());
    let mut basis: Vec<Vec<Rational>> = Vec::new();
    for (_, _, row) in &parts.entries {
        let Some(first) = row.iter().find(|c| **c != Rational::ZERO) else { continue };
        if express(&basis, row).is_none() {
            basis.push(row.iter().map(|c| c.clone() / first.clone()).collect());
            if basis.len() > system.inputs.len() {
                return Ok(None);
            }
        }
    }
    let functions: Vec<Expr> = basis.iter().map(|row| combine(&mut system.pool, row, &parts.monomials)).collect();
    let jacobian = system.pool.jacobian(&functions, &original.inputs);
    if functions.is_empty() || system.pool.rank(&jacobian, &Bindings::default())?.rank < functions.len() {
        return Ok(None);
    }
    let symbols = new_symbols(&mut system, &functions);
    let new: Vec<Expr> = symbols.iter().map(|&s| system.pool.sym(s)).collect();
    let mut dynamics = parts.drift;
    for (row, factor, combination) in &parts.entries {
        let Some(weights) = express(&basis, combination) else { return Ok(None) };
        let v = combine(&mut system.pool, &weights, &new);
        let term = system.pool.mul(*factor, v);
        dynamics[*row] = system.pool.add(dynamics[*row], term);
    }
    if !restores(&mut system, &dynamics, &new, &functions)? {
        return Ok(None);
    }
    let inputs: FxHashSet<Symbol> = original.inputs.iter().copied().collect();
    if system.outputs.iter().any(|(_, e)| system.pool.symbols_of(&[*e]).iter().any(|s| inputs.contains(s))) {
        return Ok(None);
    }
    let regular_at_point = move_point(&mut system, &functions, &jacobian)?;
    system.dynamics = dynamics;
    system.inputs = symbols;
    let input_change: Vec<NewInput> = system
        .input_names()
        .into_iter()
        .zip(&functions)
        .map(|(name, &function)| NewInput { range: range(&system.pool, &name, function), name, function })
        .collect();
    let why = reason(&system.pool, &input_change);
    system.name = format!("{}_affine", original.name);
    Ok(Some(Affinization {
        method: Method::InputChange,
        integrators: BTreeMap::new(),
        input_change,
        regular_at_point,
        system,
        why,
    }))
}

fn combine(pool: &mut Pool, weights: &[Rational], terms: &[Expr]) -> Expr {
    let mut total = pool.int(0);
    for (c, &t) in weights.iter().zip(terms) {
        let c = pool.rational(c.clone());
        let term = pool.mul(c, t);
        total = pool.add(total, term);
    }
    total
}

/// A function that is an old input keeps its name; the others are called v1, v2, …
fn new_symbols(system: &mut System, functions: &[Expr]) -> Vec<Symbol> {
    let mut new = Vec::new();
    for (k, &w) in functions.iter().enumerate() {
        let plain = system.inputs.clone().into_iter().find(|&u| system.pool.sym(u) == w);
        new.push(plain.unwrap_or_else(|| fresh(&mut system.pool, &format!("v{}", k + 1))));
    }
    new
}

/// Whether the new equations with w(u) put back are the old ones.
fn restores(system: &mut System, dynamics: &[Expr], new: &[Expr], functions: &[Expr]) -> Result<bool, Undecided> {
    let back: FxHashMap<Expr, Expr> = new.iter().copied().zip(functions.iter().copied()).collect();
    let restored = system.pool.substitute_all(dynamics, &back);
    let mut check = system.clone();
    check.dynamics = restored.iter().zip(&system.dynamics).map(|(&a, &b)| check.pool.sub(a, b)).collect();
    check.outputs.clear();
    for e in check.switched_form().dynamics {
        if !is_zero(&mut check.pool, e)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Takes the point to the new inputs and tells whether w is a local diffeomorphism (a submersion) there.
fn move_point(system: &mut System, functions: &[Expr], jacobian: &[Vec<Expr>]) -> Result<Option<bool>, Undecided> {
    let Some(point) = &mut system.point else { return Ok(None) };
    let at: FxHashMap<Expr, Expr> =
        system.inputs.iter().zip(&point.inputs).map(|(&u, &v)| (system.pool.sym(u), v)).collect();
    point.inputs = system.pool.substitute_all(functions, &at);
    let here: Vec<Vec<Expr>> = jacobian.iter().map(|row| system.pool.substitute_all(row, &at)).collect();
    let rank = system.pool.rank(&here, &Bindings::default())?.rank;
    Ok(Some(rank == functions.len()))
}

/// The values that a function can take where its form limits them.
fn range(pool: &Pool, name: &str, w: Expr) -> Option<String> {
    match pool.node(w) {
        Node::Pow(_, k) if pool.integer(k).is_some_and(|k| k % 2 == 0) => Some(format!("{name} ≥ 0")),
        Node::Pow(_, k) if pool.number(k).is_some_and(|k| !k.is_int()) => Some(format!("{name} ≥ 0")),
        Node::Call(Func::Abs, _) => Some(format!("{name} ≥ 0")),
        Node::Call(Func::Exp, _) => Some(format!("{name} > 0")),
        Node::Call(Func::Cosh, _) => Some(format!("{name} ≥ 1")),
        Node::Call(Func::Sin | Func::Cos | Func::Tanh, _) => Some(format!("|{name}| ≤ 1")),
        _ => None,
    }
}

fn reason(pool: &Pool, inputs: &[NewInput]) -> String {
    let shown: Vec<String> = inputs
        .iter()
        .filter(|v| v.name != pool.text(v.function))
        .map(|v| {
            let range = v.range.as_ref().map_or(String::new(), |r| format!(" ({r})"));
            format!("{} = {}{range}", v.name, pool.text(v.function))
        })
        .collect();
    format!(
        "the equations depend on the inputs through {} independent function{}: {}",
        inputs.len(),
        if inputs.len() == 1 { "" } else { "s" },
        shown.join(", ")
    )
}
