//! New states that make lower derivatives of the inputs suffice.
//!
//! No change z = T(x) of the state alone makes equations affine in the inputs that were not so before, for z' = DT f(x,
//! u) is affine in u if and only if f is. Where derivatives of inputs enter, though, a change z = T(x, u, …) can remove the
//! highest ones and with them integrators, as z = x − b u does for x' = a(x) + b u' (Freedman and Willems 1978; Delaleau
//! and Respondek 1995).

use bracketry_symbolic::{Expr, Func, Function, Pool, Symbol};
use rustc_hash::FxHashMap;

use crate::input_change::{Checks, canonical, fresh, without_switches};
use crate::new_state::NewState;
use crate::reason::Rejection;
use crate::switching::is_switch;
use crate::system::{InputDerivative, System};

/// Terms of the Lie series after which it is taken not to end.
const MAX_TERMS: usize = 6;

/// New states as functions of old ones and inputs, and back.
#[derive(Clone)]
pub(crate) struct Transformation {
    /// The original states.
    old: Vec<Symbol>,
    /// The new states, in the order of the old ones.
    new: Vec<Symbol>,
    /// T, one entry per new state.
    forward: Vec<Expr>,
    /// Its inverse, one entry per old state.
    back: Vec<Expr>,
}

impl Transformation {
    pub(crate) fn identity(system: &mut System) -> Self {
        let same: Vec<Expr> = system.states.clone().iter().map(|&s| system.pool.sym(s)).collect();
        let old = system.states.clone();
        Transformation { new: old.clone(), old, forward: same.clone(), back: same }
    }

    /// This one and then another of the new states.
    fn then(&self, pool: &mut Pool, new: Vec<Symbol>, forward: &[Expr], back: &FxHashMap<Expr, Expr>) -> Self {
        let old: FxHashMap<Expr, Expr> = self.new.iter().zip(&self.forward).map(|(&s, &e)| (pool.sym(s), e)).collect();
        let forward = pool.substitute_all(forward, &old);
        let back = pool.substitute_all(&self.back, back);
        Transformation { old: self.old.clone(), new, forward: canonical(pool, forward), back: canonical(pool, back) }
    }

    /// The states that are new.
    pub(crate) fn states(&self, pool: &Pool) -> Vec<NewState> {
        let all = self.old.iter().zip(&self.new).zip(self.forward.iter().zip(&self.back));
        all.filter(|((old, new), _)| old != new)
            .map(|((&old, &new), (&forward, &back))| NewState {
                name: pool.name(new).to_owned(),
                replaces: pool.name(old).to_owned(),
                function: Function::new(pool, forward),
                inverse: Function::new(pool, back),
            })
            .collect()
    }
}

/// The flow of g from s = 0, and back to it.
enum Flow {
    /// x, L_g x, L_g² x, …
    Series(Vec<Expr>),
    /// L_g x = c x with a constant c.
    Exponential(Expr),
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

/// Removes the derivative of order `order` ≥ 1, the highest that occurs, of an input.
///
/// Let x' = a + b u^(k), s = u^(k−1) and g = ∂/∂s + b ∂/∂x. The functions z_i = exp(−s g) x_i = Σ (−s)^j/j! L_g^j x_i
/// satisfy L_g z_i = 0, so their derivatives are free of u^(k); the series must end. The old states are X_i(z, s) = Σ
/// s^j/j! (L_g^j x_i)(z, 0).
pub(crate) fn lowered(
    original: &System,
    before: &Transformation,
    input: usize,
    order: u32,
    checks: &mut Checks,
) -> Result<(System, Transformation), Rejection> {
    let mut system = original.clone();
    let top = derivative_symbol(&mut system, input, order);
    let below = derivative_symbol(&mut system, input, order - 1);
    let chain: Vec<(Symbol, Symbol)> = (0..order)
        .map(|k| (derivative_symbol(&mut system, input, k), derivative_symbol(&mut system, input, k + 1)))
        .collect();
    let b = coefficients(&mut system, top, &chain)?;
    let NewStates { z, forward, back } = new_states(&mut system, before, &b, [top, below], checks)?;

    // z' = ∂T/∂x f + Σ ∂T/∂u^(j) u^(j+1), free of the highest derivative.
    let (states, f) = (system.states.clone(), system.dynamics.clone());
    let mut dynamics = Vec::new();
    for &t in &forward {
        let rate = total_derivative(&mut system.pool, t, &states, &f, &chain);
        dynamics.push(rate);
    }
    let (mut probe, smooth) = without_switches(&system, &dynamics);
    for &e in &smooth {
        let d = probe.pool.diff(e, top);
        if !checks.is_zero(&mut probe.pool, d)? {
            return Err(Rejection::Remains { derivative: system.pool.name(top).to_owned() });
        }
    }
    let pool = &mut system.pool;
    let (top_expr, zero) = (pool.sym(top), pool.int(0));
    let mut map = back.clone();
    map.insert(top_expr, zero);
    let dynamics = pool.substitute_all(&dynamics, &map);
    let dynamics: Vec<Expr> = dynamics.into_iter().map(|e| pool.simplify(e)).collect();

    // Back: d/dt X(z, s) must be f at X.
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
            return Err(Rejection::NotInverted);
        }
    }
    let transformation = before.then(&mut system.pool, z.clone(), &forward, &back);
    replace_states(&mut system, &z, dynamics, &forward, &back, top);
    Ok((system, transformation))
}

/// The coefficients b of u^(k) in the equations, which may depend on states, parameters and lower derivatives of u only.
fn coefficients(system: &mut System, top: Symbol, chain: &[(Symbol, Symbol)]) -> Result<Vec<Expr>, Rejection> {
    let parameters = system.parameters.iter().map(|p| p.symbol);
    let allowed: Vec<Symbol> =
        system.states.iter().copied().chain(chain.iter().map(|c| c.0)).chain(parameters).collect();
    let pool = &mut system.pool;
    let derivative = pool.name(top).to_owned();
    if system.outputs.iter().any(|o| pool.depends_on(o.1, top)) {
        return Err(Rejection::OutputDepends { derivative });
    }
    let all = pool.reachable(&system.dynamics);
    if all.into_iter().any(|n| is_switch(pool.node(n)) && pool.depends_on(n, top)) {
        return Err(Rejection::SwitchDepends { derivative });
    }
    let mut b = Vec::with_capacity(system.dynamics.len());
    for &e in &system.dynamics {
        let d = pool.diff(e, top);
        b.push(pool.simplify(d));
    }
    if pool.reachable(&b).iter().any(|&n| is_switch(pool.node(n))) {
        return Err(Rejection::CoefficientJumps { derivative });
    }
    if let Some(&s) = pool.symbols_of(&b).iter().find(|s| !allowed.contains(s)) {
        return Err(if s == top {
            Rejection::Nonlinear { derivative }
        } else {
            Rejection::CoefficientDepends { derivative, on: pool.name(s).to_owned() }
        });
    }
    Ok(b)
}

/// z = T(x), and x = X(z, s) for each old state.
struct NewStates {
    z: Vec<Symbol>,
    forward: Vec<Expr>,
    back: FxHashMap<Expr, Expr>,
}

/// T and X by the flow of g, states named `z_…` once; `top` is u^(k), `below` s.
fn new_states(
    system: &mut System,
    before: &Transformation,
    b: &[Expr],
    [top, below]: [Symbol; 2],
    checks: &mut Checks,
) -> Result<NewStates, Rejection> {
    let (pool, states) = (&mut system.pool, &system.states);
    let s = pool.sym(below);
    let mut z = Vec::new();
    let (mut forward, mut back) = (Vec::new(), FxHashMap::default());
    let mut to_new: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut flows = Vec::new();
    for &x in states {
        let e = pool.sym(x);
        let Some(flow) = flow(pool, states, b, below, e, checks)? else {
            return Err(Rejection::NoClosedForm { derivative: pool.name(top).to_owned() });
        };
        let unchanged = matches!(&flow, Flow::Series(terms) if terms.len() == 1) || !before.old.contains(&x);
        let new = if unchanged { x } else { fresh(pool, &format!("z_{}", pool.name(x).to_owned())) };
        let new_expr = pool.sym(new);
        to_new.insert(e, new_expr);
        z.push(new);
        flows.push(flow);
    }
    let zero = pool.int(0);
    let start: FxHashMap<Expr, Expr> = to_new.iter().map(|(&a, &b)| (a, b)).chain([(s, zero)]).collect();
    for (flow, &x) in flows.iter().zip(states) {
        let (x, minus) = (pool.sym(x), pool.neg(s));
        let (t, old) = match flow {
            Flow::Series(terms) => {
                let at_start = pool.substitute_all(terms, &start);
                (weighted(pool, terms, minus), weighted(pool, &at_start, s))
            }
            Flow::Exponential(c) => {
                let (down, up) = (pool.mul(*c, minus), pool.mul(*c, s));
                let (down, up) = (pool.call(Func::Exp, down), pool.call(Func::Exp, up));
                (pool.mul(x, down), pool.mul(to_new[&x], up))
            }
        };
        forward.push(t);
        back.insert(x, old);
    }
    Ok(NewStates { z, forward, back })
}

/// The flow of g on one state; `None` if its series neither ends within [`MAX_TERMS`] nor is exponential.
fn flow(
    pool: &mut Pool,
    states: &[Symbol],
    b: &[Expr],
    below: Symbol,
    first: Expr,
    checks: &mut Checks,
) -> Result<Option<Flow>, Rejection> {
    let mut terms = vec![first];
    for _ in 0..MAX_TERMS {
        let last = terms[terms.len() - 1];
        let along = pool.lie_derivative(last, states, b);
        let direct = pool.diff(last, below);
        let sum = pool.add(along, direct);
        let next = pool.simplify(sum);
        if checks.is_zero(pool, next)? {
            return Ok(Some(Flow::Series(terms)));
        }
        if terms.len() == 1 {
            let ratio = pool.div(next, first);
            let c = pool.simplify(ratio);
            if pool.symbols_of(&[c]).iter().all(|s| *s != below && !states.contains(s)) {
                return Ok(Some(Flow::Exponential(c)));
            }
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
