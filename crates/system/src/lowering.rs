//! New states that make lower derivatives of the inputs suffice.
//!
//! No change z = T(x) of the state alone makes equations affine in the inputs that were not so before, for z' = DT f(x, u) is affine
//! in u exactly if f is. Where derivatives of inputs enter, though, a change z = T(x, u, …) can remove the highest ones and with
//! them integrators, as z = x − b u does for x' = a(x) + b u' (Freedman and Willems, IEEE Trans. Automat. Control 23, 1978;
//! Delaleau and Respondek, J. Math. Syst. Estim. Control 5, 1995).

use bracketry_symbolic::{Expr, Func, Func2, Node, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::candidate::NewState;
use crate::input_change::{Checks, Rejection, canonical, fresh, without_switches};
use crate::system::{InputDerivative, System};

/// Terms of the Lie series after which it is taken not to end.
const MAX_TERMS: usize = 6;

/// A system with the highest derivative of an input removed.
pub(crate) struct Lowered {
    pub(crate) system: System,
    pub(crate) states: Vec<NewState>,
}

/// The symbol of the derivative of order k of an input.
fn derivative_symbol(system: &mut System, input: usize, order: u32) -> Symbol {
    if order == 0 {
        return system.inputs[input];
    }
    if let Some(d) = system.input_derivatives.iter().find(|d| d.input == input && d.order == order) {
        return d.symbol;
    }
    let name = system.pool.name(system.inputs[input]).to_owned();
    let text = if order == 1 { format!("der({name})") } else { format!("der({name}, {order})") };
    let symbol = system.pool.symbol(&text);
    system.input_derivatives.push(InputDerivative { input, order, symbol });
    symbol
}

fn is_switch(node: Node) -> bool {
    matches!(node, Node::Call(Func::Sign | Func::Abs, _) | Node::Call2(Func2::Min | Func2::Max, ..))
}

fn no(reason: String) -> Rejection {
    Rejection::Because(reason)
}

/// Removes the derivative of order `order` ≥ 1, the highest that occurs, of an input.
///
/// Let x' = a + b u^(k), s = u^(k−1) and g = ∂/∂s + b ∂/∂x. The functions z_i = exp(−s g) x_i = Σ (−s)^j/j! L_g^j x_i satisfy
/// L_g z_i = 0, so their derivatives are free of u^(k); the series must end. The old states are X_i(z, s) = Σ s^j/j! (L_g^j x_i)(z, 0).
pub(crate) fn lowered(original: &System, input: usize, order: u32, checks: &mut Checks) -> Result<Lowered, Rejection> {
    let mut system = original.clone();
    let top = derivative_symbol(&mut system, input, order);
    let below = derivative_symbol(&mut system, input, order - 1);
    let name = system.pool.name(top).to_owned();
    let chain: Vec<(Symbol, Symbol)> = (0..order)
        .map(|k| (derivative_symbol(&mut system, input, k), derivative_symbol(&mut system, input, k + 1)))
        .collect();
    let allowed: Vec<Symbol> = system
        .states
        .iter()
        .copied()
        .chain(chain.iter().map(|c| c.0))
        .chain(system.parameters.iter().map(|p| p.symbol))
        .collect();
    let states = system.states.clone();
    let f = system.dynamics.clone();
    let pool = &mut system.pool;
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    if outputs.iter().any(|&e| pool.depends_on(e, top)) {
        return Err(no(format!("an output depends on {name}")));
    }
    let all = pool.reachable(&f);
    if all.into_iter().any(|n| is_switch(pool.node(n)) && pool.depends_on(n, top)) {
        return Err(no(format!("a switching function depends on {name}")));
    }
    let mut b = Vec::with_capacity(f.len());
    for &e in &f {
        let d = pool.diff(e, top);
        b.push(pool.simplify(d));
    }
    if pool.reachable(&b).iter().any(|&n| is_switch(pool.node(n))) {
        return Err(no(format!("the coefficient of {name} jumps with the sign of a switching function")));
    }
    if let Some(&s) = pool.symbols_of(&b).iter().find(|s| !allowed.contains(s)) {
        return Err(no(if s == top {
            format!("{name} enters nonlinearly")
        } else {
            format!("the coefficient of {name} depends on {}", pool.name(s))
        }));
    }

    // T and X as Lie series.
    let s = pool.sym(below);
    let mut z_names = Vec::new();
    let (mut forward, mut back) = (Vec::new(), FxHashMap::default());
    let mut to_new: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut series = Vec::new();
    for (i, &x) in states.iter().enumerate() {
        let e = pool.sym(x);
        let terms = lie_series(pool, &states, &b, below, e, checks)?
            .ok_or_else(|| no(format!("the states that are free of {name} were not found in closed form")))?;
        let z = if terms.len() == 1 { x } else { fresh(pool, &format!("z_{}", pool.name(x).to_owned())) };
        let z_expr = pool.sym(z);
        to_new.insert(e, z_expr);
        z_names.push((i, z));
        series.push(terms);
    }
    let zero = pool.int(0);
    let start: FxHashMap<Expr, Expr> = to_new.iter().map(|(&a, &b)| (a, b)).chain([(s, zero)]).collect();
    for (terms, &x) in series.iter().zip(&states) {
        let minus = pool.neg(s);
        let t = weighted(pool, terms, minus);
        forward.push(t);
        let at_start = pool.substitute_all(terms, &start);
        let sum = weighted(pool, &at_start, s);
        let x = pool.sym(x);
        back.insert(x, sum);
    }

    // z' = ∂T/∂x f + Σ ∂T/∂u^(j) u^(j+1), free of the highest derivative.
    let mut dynamics = Vec::new();
    for &t in &forward {
        let rate = total_derivative(pool, t, &states, &f, &chain);
        dynamics.push(rate);
    }
    let (mut probe, smooth) = without_switches(&system, &dynamics);
    for &e in &smooth {
        let d = probe.pool.diff(e, top);
        if !checks.is_zero(&mut probe.pool, d)? {
            return Err(no(format!("{name} does not cancel")));
        }
    }
    let pool = &mut system.pool;
    let top_expr = pool.sym(top);
    let mut map = back.clone();
    map.insert(top_expr, zero);
    let dynamics = pool.substitute_all(&dynamics, &map);
    let dynamics: Vec<Expr> = dynamics.into_iter().map(|e| pool.simplify(e)).collect();

    // Back: d/dt X(z, s) must be f at X.
    let z: Vec<Symbol> = z_names.iter().map(|n| n.1).collect();
    let mut differences = Vec::new();
    for (&x, &e) in states.iter().zip(&f) {
        let x = pool.sym(x);
        let rate = total_derivative(pool, back[&x], &z, &dynamics, &chain);
        let wanted = pool.substitute(e, &back);
        differences.push(pool.sub(rate, wanted));
    }
    let differences = canonical(pool, differences);
    let (mut probe, smooth) = without_switches(&system, &differences);
    for e in smooth {
        if !checks.is_zero(&mut probe.pool, e)? {
            return Err(no("the way back does not give the equations".to_owned()));
        }
    }
    let states_described = describe(&mut system, &z_names, &forward, &back);
    replace_states(&mut system, &z, dynamics, &forward, &back, top);
    Ok(Lowered { system, states: states_described })
}

/// x_i, L_g x_i, L_g² x_i, … without the zero at the end; `None` if there is none within [`MAX_TERMS`].
fn lie_series(
    pool: &mut Pool,
    states: &[Symbol],
    b: &[Expr],
    below: Symbol,
    first: Expr,
    checks: &mut Checks,
) -> Result<Option<Vec<Expr>>, Rejection> {
    let mut terms = vec![first];
    for _ in 0..MAX_TERMS {
        let last = terms[terms.len() - 1];
        let along = pool.lie_derivative(last, states, b);
        let direct = pool.diff(last, below);
        let sum = pool.add(along, direct);
        let next = pool.simplify(sum);
        if checks.is_zero(pool, next)? {
            return Ok(Some(terms));
        }
        terms.push(next);
    }
    Ok(None)
}

/// Σ s^j/j! terms_j
fn weighted(pool: &mut Pool, terms: &[Expr], s: Expr) -> Expr {
    let mut total = pool.int(0);
    let mut factorial = 1;
    for (j, &t) in terms.iter().enumerate() {
        factorial *= i64::try_from(j.max(1)).unwrap_or(1);
        let weight = pool.ratio(1, factorial);
        let power = pool.powi(s, j as i64);
        let term = pool.mul(weight, power);
        let term = pool.mul(term, t);
        total = pool.add(total, term);
    }
    pool.simplify(total)
}

fn total_derivative(pool: &mut Pool, e: Expr, states: &[Symbol], f: &[Expr], chain: &[(Symbol, Symbol)]) -> Expr {
    let mut total = pool.lie_derivative(e, states, f);
    for &(u, rate) in chain {
        let d = pool.diff(e, u);
        let rate = pool.sym(rate);
        let term = pool.mul(d, rate);
        total = pool.add(total, term);
    }
    total
}

fn describe(
    system: &mut System,
    z: &[(usize, Symbol)],
    forward: &[Expr],
    back: &FxHashMap<Expr, Expr>,
) -> Vec<NewState> {
    let mut out = Vec::new();
    for &(i, new) in z {
        let old = system.states[i];
        if old == new {
            continue;
        }
        let x = system.pool.sym(old);
        out.push(NewState {
            name: system.pool.name(new).to_owned(),
            replaces: system.pool.name(old).to_owned(),
            function: system.pool.text(forward[i]),
            inverse: system.pool.text(back[&x]),
        });
    }
    out
}

fn replace_states(
    system: &mut System,
    z: &[Symbol],
    dynamics: Vec<Expr>,
    forward: &[Expr],
    back: &FxHashMap<Expr, Expr>,
    removed: Symbol,
) {
    let zero = system.pool.int(0);
    if let Some(point) = system.point.clone() {
        let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
        for d in &system.input_derivatives {
            at.insert(system.pool.sym(d.symbol), zero);
        }
        let values = system.states.iter().zip(&point.states).chain(system.inputs.iter().zip(&point.inputs));
        for (&s, &v) in values {
            at.insert(system.pool.sym(s), v);
        }
        // A point holds numbers; those of parameters are theirs.
        let with_values = system.with_values(forward);
        let states = system.pool.substitute_all(&with_values, &at);
        if let Some(p) = &mut system.point {
            p.states = states;
        }
    }
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let outputs = system.pool.substitute_all(&outputs, back);
    for (o, e) in system.outputs.iter_mut().zip(outputs) {
        o.1 = e;
    }
    system.definitions.clear();
    system.states = z.to_vec();
    system.dynamics = dynamics;
    let mut all = system.dynamics.clone();
    all.extend(system.outputs.iter().map(|o| o.1));
    let used = system.pool.symbols_of(&all);
    system.input_derivatives.retain(|d| d.symbol != removed && used.contains(&d.symbol));
}
