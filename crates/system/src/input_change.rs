//! New inputs v = w(u) or v = w(x, u): completion of a change that was found, with its certificate.

use bracketry_symbolic::{
    Bindings, Certificate, Expr, Func, Function, Node, Pool, Rational, Symbol, Undecided, ZeroTest,
};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::candidate::{Candidate, Method};
use crate::hull::{Center, surrounds_point};
use crate::images::{flattened, input_domain, number};
use crate::inverse::inverse;
use crate::new_input::{AtPoint, NewInput};
use crate::range::{Bound, Range, image, range};
use crate::reason::{AffineReason, Rejection};
use crate::singular::singular_set;
use crate::system::System;

/// x' = a(x) + B(x) w(x, u), and the same for outputs that depend on inputs.
pub(crate) struct Change {
    /// w
    pub(crate) functions: Vec<Expr>,
    /// a, one entry per equation, then one per output.
    pub(crate) rest: Vec<Expr>,
    /// B, one row per equation, then one per output.
    pub(crate) factors: Vec<Vec<Expr>>,
}

/// Exact zero tests, with the certificate of all of them together.
#[derive(Default)]
pub(crate) struct Checks {
    pub(crate) certificate: Option<Certificate>,
}

impl Checks {
    /// Whether `e`, which must be free of switches, is zero.
    pub(crate) fn is_zero(&mut self, pool: &mut Pool, e: Expr) -> Result<bool, Undecided> {
        if pool.is_zero(e) {
            return Ok(true);
        }
        match pool.zero_test(e, &Bindings::default()) {
            ZeroTest::Zero(c) => {
                self.certificate = Some(self.certificate.map_or(c, |old| old.and(c)));
                Ok(true)
            }
            ZeroTest::NonZero => Ok(false),
            ZeroTest::Unknown(u) => Err(u),
        }
    }
}

/// Expressions with the sign of every switching function as a symbol.
pub(crate) fn without_switches(system: &System, expressions: &[Expr]) -> (System, Vec<Expr>) {
    let mut s = system.clone();
    s.dynamics = expressions.to_vec();
    s.outputs.clear();
    let form = s.switched_form();
    (s, form.dynamics)
}

/// Simplified, so that equal arguments of switching functions are one expression.
pub(crate) fn canonical(pool: &mut Pool, expressions: Vec<Expr>) -> Vec<Expr> {
    expressions.into_iter().map(|e| pool.simplify(e)).collect()
}

/// The equations, then the outputs.
pub(crate) fn rows(system: &System) -> Vec<Expr> {
    system.dynamics.iter().copied().chain(system.outputs.iter().map(|o| o.1)).collect()
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

/// A name that the system does not use yet.
pub(crate) fn fresh(pool: &mut Pool, wanted: &str) -> Symbol {
    let mut name = wanted.to_owned();
    while pool.find_symbol(&name).is_some() {
        name.push('_');
    }
    pool.symbol(&name)
}

/// The system with v = w as inputs. Checked by putting w back.
pub(crate) fn apply(original: &System, change: Change) -> Result<Candidate, Rejection> {
    let mut system = original.clone();
    let Change { functions, rest, factors } = change;
    let independent = rank_of_jacobian(&system, &functions, None)?;
    if independent < functions.len() {
        return Err(Rejection::Dependent { functions: functions.len(), independent });
    }
    let symbols = new_symbols(&mut system, &functions);
    let new: Vec<Expr> = symbols.iter().map(|&s| system.pool.sym(s)).collect();
    let mut affine = Vec::with_capacity(rest.len());
    for (&a, b) in rest.iter().zip(&factors) {
        let mut total = a;
        for (&b, &v) in b.iter().zip(&new) {
            let term = system.pool.mul(b, v);
            total = system.pool.add(total, term);
        }
        affine.push(total);
    }
    let mut checks = Checks::default();
    if !restores(&system, &affine, &new, &functions, &mut checks)? {
        return Err(Rejection::NotRestored);
    }
    let states: FxHashSet<Symbol> = system.states.iter().copied().collect();
    let uses_states = system.pool.symbols_of(&functions).iter().any(|s| states.contains(s));
    let method = if uses_states { Method::Feedback } else { Method::InputChange };
    let input_change = describe(&mut system, &symbols, &functions)?;
    let mut candidate = Candidate::new(method, reason(&system.pool, &input_change));
    candidate.certificate = checks.certificate;
    candidate.independent_ranges = independent_ranges(&mut system, &functions, &input_change);
    candidate.regular_at_point = regular_at_point(&system, &functions);
    candidate.interior_at_point = interior_at_point(&mut system, &functions, &candidate, &input_change);
    candidate.covers_at_point = covers_at_point(&system, &candidate, &input_change);
    candidate.singular_set = singular_set(&mut system, &functions);
    candidate.inverse = inverse(&mut system, &functions, &symbols);
    candidate.input_change = input_change;
    if let Some(values) = at_point(&mut system, &functions)
        && let Some(point) = &mut system.point
    {
        point.inputs = values;
    }
    let n = system.states.len();
    system.dynamics = affine[..n].to_vec();
    for (o, &e) in system.outputs.iter_mut().zip(&affine[n..]) {
        o.1 = e;
    }
    system.inputs = symbols;
    candidate.system = Some(system);
    Ok(candidate)
}

/// Generic rank of ∂w/∂u, or the rank with states and inputs at the values of `at`.
fn rank_of_jacobian(
    system: &System,
    functions: &[Expr],
    at: Option<&FxHashMap<Expr, Expr>>,
) -> Result<usize, Undecided> {
    let (mut s, smooth) = without_switches(system, functions);
    let mut rows = s.pool.jacobian(&smooth, &s.inputs.clone());
    if let Some(at) = at {
        rows = rows.iter().map(|row| s.pool.substitute_all(row, at)).collect();
    }
    if rows.is_empty() || s.inputs.is_empty() {
        return Ok(0);
    }
    Ok(s.pool.rank(&rows, &Bindings::default())?.rank)
}

/// Whether the new equations with w put back are the old ones.
fn restores(
    system: &System,
    affine: &[Expr],
    new: &[Expr],
    functions: &[Expr],
    checks: &mut Checks,
) -> Result<bool, Undecided> {
    let mut check = system.clone();
    let back: FxHashMap<Expr, Expr> = new.iter().copied().zip(functions.iter().copied()).collect();
    let restored = check.pool.substitute_all(affine, &back);
    let differences: Vec<Expr> = restored.iter().zip(rows(system)).map(|(&a, b)| check.pool.sub(a, b)).collect();
    let differences = canonical(&mut check.pool, differences);
    let (mut check, smooth) = without_switches(&check, &differences);
    for e in smooth {
        if !checks.is_zero(&mut check.pool, e)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// States, inputs and parameters at the point; `None` if there is no point.
fn point_values(system: &mut System) -> Option<FxHashMap<Expr, Expr>> {
    let point = system.point.clone()?;
    let mut at = FxHashMap::default();
    let values = system.states.iter().zip(&point.states).chain(system.inputs.iter().zip(&point.inputs));
    for (&s, &v) in values {
        at.insert(system.pool.sym(s), v);
    }
    for p in &system.parameters {
        at.insert(system.pool.sym(p.symbol), system.pool.rational(p.value.clone()));
    }
    Some(at)
}

/// The functions at the point.
fn at_point(system: &mut System, functions: &[Expr]) -> Option<Vec<Expr>> {
    let at = point_values(system)?;
    Some(system.pool.substitute_all(functions, &at))
}

fn describe(system: &mut System, symbols: &[Symbol], functions: &[Expr]) -> Result<Vec<NewInput>, Rejection> {
    let here = at_point(system, functions);
    let with_values = system.with_values(functions);
    let domain = input_domain(system);
    let mut out = Vec::new();
    for (k, (&s, &function)) in symbols.iter().zip(functions).enumerate() {
        let name = system.pool.name(s).to_owned();
        let values = range(&mut system.pool, with_values[k], &domain);
        if let Range::Unknown { reason } = &values {
            let (s, smooth) = without_switches(system, &[function]);
            if s.pool.symbols_of(&smooth).len() > s.pool.symbols_of(&[function]).len() {
                return Err(Rejection::Switches { function: Function::new(&s.pool, function), reason: reason.clone() });
            }
        }
        let mut at_point = match &here {
            Some(here) => place(&mut system.pool, here[k], &values),
            None => AtPoint::Unknown,
        };
        let open = at_point == AtPoint::Unknown && system.point.is_some();
        let regular = |s: &System| inside_ranges(s) && regular_at_point(s, &[function]) == Some(true);
        if open && (regular(system) || surrounded(system, &[function])) {
            at_point = AtPoint::Interior;
        }
        out.push(NewInput { name, function, values, at_point });
    }
    Ok(out)
}

/// Where a value lies among all values.
fn place(pool: &mut Pool, value: Expr, values: &Range) -> AtPoint {
    let Some(v) = number(pool, value) else { return AtPoint::Unknown };
    let Range::Interval { lower, upper } = values else {
        return if *values == Range::Onto { AtPoint::Interior } else { AtPoint::Unknown };
    };
    let scale = 1e-9 * (1.0 + v.abs());
    let gap = |bound: &Option<Bound>, side: f64| bound.as_ref().map_or(f64::INFINITY, |b| side * (v - b.value));
    let (above, below) = (gap(lower, 1.0), gap(upper, -1.0));
    if above > scale && below > scale {
        return AtPoint::Interior;
    }
    // So near a bound only an exact comparison will do.
    let bound = if above <= scale { lower } else { upper };
    let Some(exact) = bound.as_ref().and_then(|b| b.exact.as_ref()) else { return AtPoint::Unknown };
    let exact = exact.copied_into(pool);
    let difference = pool.sub(value, exact);
    match pool.zero_test(difference, &Bindings::default()) {
        ZeroTest::Zero(_) if above <= scale => AtPoint::AtLower,
        ZeroTest::Zero(_) => AtPoint::AtUpper,
        ZeroTest::NonZero => AtPoint::Interior,
        ZeroTest::Unknown(_) => AtPoint::Unknown,
    }
}

/// Whether w is a submersion at the point; `None` without a point or where that is undecided.
fn regular_at_point(system: &System, functions: &[Expr]) -> Option<bool> {
    let mut s = system.clone();
    let at = point_values(&mut s)?;
    // The sign of a switching function has no value where that vanishes: there w is not differentiable.
    let (mut s, smooth) = without_switches(&s, functions);
    let switches = s.pool.symbols_of(&smooth).len() > s.pool.symbols_of(functions).len();
    let rows = s.pool.jacobian(&smooth, &s.inputs.clone());
    let rows: Vec<Vec<Expr>> = rows.iter().map(|row| s.pool.substitute_all(row, &at)).collect();
    let rank = s.pool.rank(&rows, &Bindings::default()).ok()?.rank;
    match rank == functions.len() {
        true if switches => None,
        full => Some(full),
    }
}

/// Whether every two of the functions use different inputs, or their ranges are those of plane polar coordinates.
fn independent_ranges(system: &mut System, functions: &[Expr], described: &[NewInput]) -> Option<bool> {
    let inputs: FxHashSet<Symbol> = system.inputs.iter().copied().collect();
    let mut uses: Vec<FxHashSet<Symbol>> = functions
        .iter()
        .map(|&w| system.pool.symbols_of(&[w]).into_iter().filter(|s| inputs.contains(s)).collect())
        .collect();
    let mut open: Vec<usize> = Vec::new();
    for (i, u) in uses.iter().enumerate() {
        if uses.iter().enumerate().any(|(j, v)| j != i && !u.is_disjoint(v)) {
            open.push(i);
        }
    }
    if open.is_empty() {
        return Some(true);
    }
    let [i, j] = open[..] else { return None };
    // The members of the pair may share inputs with each other only.
    let pair: FxHashSet<Symbol> = uses.swap_remove(j).union(&uses[i]).copied().collect();
    let others = functions.iter().enumerate().filter(|(k, _)| *k != i && *k != j);
    let shared = |e: Expr| system.pool.symbols_of(&[e]).iter().any(|s| pair.contains(s));
    let plane = others.into_iter().all(|(_, &e)| !shared(e))
        && described[i].values == Range::Onto
        && described[j].values == Range::Onto
        && is_polar(system, functions[i], functions[j]);
    plane.then_some(true)
}

/// Whether the two are a·ρ·cos φ and b·ρ·sin φ with numbers a, b, where ρ takes all real numbers (or all that are not
/// negative) and φ, independently, all angles.
fn is_polar(system: &mut System, v: Expr, w: Expr) -> bool {
    let values = system.with_values(&[v, w]);
    let (inputs, domain) = (system.inputs.clone(), input_domain(system));
    let pool = &mut system.pool;
    let split = |pool: &mut Pool, e: Expr| {
        let (mut angle, mut radius) = (None, pool.int(1));
        for f in flattened(pool, e, false) {
            match pool.node(f) {
                Node::Call(g @ (Func::Sin | Func::Cos), a) if angle.is_none() => angle = Some((g, a)),
                _ if pool.number(f).is_some() => {}
                _ => radius = pool.mul(radius, f),
            }
        }
        angle.map(|(g, a)| (g, a, radius))
    };
    let (Some((f, a, r)), Some((g, b, s))) = (split(pool, values[0]), split(pool, values[1])) else { return false };
    let independent = !pool.symbols_of(&[a]).iter().any(|x| inputs.contains(x) && pool.depends_on(r, *x));
    let turns = image(pool, a, &domain).is_ok_and(|i| i.is_all());
    let far = image(pool, r, &domain).is_ok_and(|i| i.lower.value <= 0.0 && i.upper.value == f64::INFINITY);
    f != g && a == b && r == s && independent && turns && far
}

/// Whether the values of the new inputs at the point lie inside the convex hull of all that they take together.
fn interior_at_point(
    system: &mut System,
    functions: &[Expr],
    candidate: &Candidate,
    inputs: &[NewInput],
) -> Option<bool> {
    system.point.as_ref()?;
    if candidate.regular_at_point == Some(true) && inside_ranges(system) {
        return Some(true);
    }
    if inputs.iter().any(|v| matches!(v.at_point, AtPoint::AtLower | AtPoint::AtUpper)) {
        return Some(false);
    }
    let each = inputs.iter().all(|v| v.at_point == AtPoint::Interior);
    let inside = (each && candidate.independent_ranges == Some(true)) || surrounded(system, functions);
    inside.then_some(true)
}

/// Whether the new inputs take all values near those at the point: where the Jacobian has full rank (inverse function
/// theorem), or where each has a range without gaps around its value and takes its values independently of the others.
fn covers_at_point(system: &System, candidate: &Candidate, inputs: &[NewInput]) -> Option<bool> {
    match (candidate.regular_at_point, candidate.interior_at_point) {
        (Some(true), _) if inside_ranges(system) => Some(true),
        (_, Some(false)) => Some(false),
        (_, Some(true)) => {
            let known = inputs.iter().all(|v| !matches!(v.values, Range::Unknown { .. }));
            (known && candidate.independent_ranges == Some(true)).then_some(true)
        }
        _ => None,
    }
}

/// Whether values on all sides of those at the point are seen.
fn surrounded(system: &mut System, functions: &[Expr]) -> bool {
    let Some((_, at)) = system.point_values() else { return false };
    let Some(mut values) = point_values(system) else { return false };
    let inputs = system.inputs.clone();
    for &u in &inputs {
        let u = system.pool.sym(u);
        values.remove(&u);
    }
    let here = system.pool.substitute_all(functions, &values);
    let domain = input_domain(system);
    let limits: Vec<[f64; 2]> = inputs.iter().map(|u| [domain[u].lower.value, domain[u].upper.value]).collect();
    surrounds_point(system, &here, &inputs, &Center { at: &at, limits: &limits })
}

/// Whether every input that has a range is inside it at the point, not at an end.
fn inside_ranges(system: &System) -> bool {
    let Some((_, at)) = system.point_values() else { return system.input_ranges.is_empty() };
    let beyond = |end: &Option<Rational>, value: f64, side: f64| {
        end.as_ref().is_none_or(|end| side * (end.to_f64().value() - value) > 0.0)
    };
    system.input_ranges.iter().all(|r| match system.inputs.iter().position(|u| *u == r.input) {
        Some(k) => beyond(&r.min, at[k], -1.0) && beyond(&r.max, at[k], 1.0),
        None => true,
    })
}

fn reason(pool: &Pool, inputs: &[NewInput]) -> AffineReason {
    let is_new = |v: &&NewInput| !matches!(pool.node(v.function), Node::Sym(s) if pool.name(s) == v.name);
    let changed = |v: &NewInput| (v.name.clone(), Function::new(pool, v.function), v.values.clone());
    AffineReason::NewInputs { functions: inputs.len(), changed: inputs.iter().filter(is_new).map(changed).collect() }
}
