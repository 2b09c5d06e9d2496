//! Making a system affine in its inputs: recognition, change of inputs, integrators in front of inputs.

use std::collections::BTreeMap;

use bracketry_symbolic::{Bindings, Expr, Node, Pool, Symbol, Undecided, ZeroTest};
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

use crate::system::{InputDerivative, Point, System};

/// x' = drift(x) + Σ fields_i(x) u_i.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AffineForm {
    /// One expression per state.
    pub drift: Vec<Expr>,
    /// One vector field per input.
    pub fields: Vec<Vec<Expr>>,
}

/// How a system became affine.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// It is affine as it stands.
    None,
    /// New inputs v = w(u).
    InputChange,
    /// Integrators: u becomes a state and its derivative the input.
    InputAugmentation,
}

/// A system made affine in its inputs, and how.
#[derive(Clone, Debug)]
pub struct Affinization {
    /// What was done.
    pub method: Method,
    /// Integrators in front of each input that got any.
    pub integrators: BTreeMap<String, u32>,
    /// For [`Method::InputChange`]: each new input and the function of the old ones that it stands for.
    pub input_change: Vec<(String, Expr)>,
    /// The affine system.
    pub system: System,
    /// The reason, in a sentence.
    pub why: String,
}

/// Why no affine form was given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AffineError {
    /// An exact test came out undecided.
    #[error("whether the equations are affine in the inputs is undecided: {0}")]
    Undecided(#[from] Undecided),
    /// More inputs than the search over subsets takes.
    #[error("{inputs} inputs are too many for the search over integrators; at most {MAX_INPUTS} are tried")]
    TooManyInputs {
        /// Number of inputs.
        inputs: usize,
    },
}

const MAX_INPUTS: usize = 16;
/// Products of sums are multiplied out up to this many terms when looking for functions of the inputs.
const MAX_TERMS: usize = 2000;

fn is_zero(pool: &mut Pool, e: Expr) -> Result<bool, Undecided> {
    if pool.is_zero(e) {
        return Ok(true);
    }
    match pool.zero_test(e, &Bindings::default()) {
        ZeroTest::Zero(_) => Ok(true),
        ZeroTest::NonZero => Ok(false),
        ZeroTest::Unknown(u) => Err(u),
    }
}

impl System {
    /// Drift and input fields, or `None` if the equations are not affine in the inputs or
    /// use derivatives of inputs. For a smooth system (a mode, or a smoothed one).
    ///
    /// # Errors
    /// [`Undecided`] if an exact test cannot decide.
    pub fn affine_form(&mut self) -> Result<Option<AffineForm>, Undecided> {
        if !self.input_derivatives.is_empty() || !self.curvature(&self.inputs.clone())?.is_empty() {
            return Ok(None);
        }
        let zero = self.pool.int(0);
        let at_zero: FxHashMap<Expr, Expr> =
            self.inputs.clone().into_iter().map(|s| (self.pool.sym(s), zero)).collect();
        let f = self.dynamics.clone();
        let drift = self.pool.substitute_all(&f, &at_zero);
        let mut fields = Vec::new();
        for u in self.inputs.clone() {
            let column: Vec<Expr> = f.iter().map(|&e| self.pool.diff(e, u)).collect();
            fields.push(self.pool.substitute_all(&column, &at_zero));
        }
        Ok(Some(AffineForm { drift, fields }))
    }

    /// The pairs (i ≤ j) of `arguments` in which the right-hand side is not affine:
    /// a second derivative that is not zero, or (i, i) for an argument of a switching function.
    fn curvature(&mut self, arguments: &[Symbol]) -> Result<Vec<(usize, usize)>, Undecided> {
        let form = self.switched_form();
        let mut pairs = Vec::new();
        let surfaces: Vec<Expr> = form.switches.iter().map(|s| s.surface).collect();
        let in_surface: FxHashSet<Symbol> = self.pool.symbols_of(&surfaces).into_iter().collect();
        for (i, &u) in arguments.iter().enumerate() {
            if in_surface.contains(&u) {
                pairs.push((i, i));
            }
            let first: Vec<Expr> = form.dynamics.iter().map(|&e| self.pool.diff(e, u)).collect();
            for (j, &v) in arguments.iter().enumerate().skip(i) {
                if pairs.contains(&(i, j)) {
                    continue;
                }
                for &d in &first {
                    let second = self.pool.diff(d, v);
                    if !is_zero(&mut self.pool, second)? {
                        pairs.push((i, j));
                        break;
                    }
                }
            }
        }
        Ok(pairs)
    }

    /// Makes the system affine in its inputs: as it stands if possible, else by new inputs
    /// v = w(u) when the equations depend on u through at most as many functions as there are
    /// inputs, else by the least number of integrators in front of inputs
    /// (Nijmeijer & van der Schaft 1990, sec. 6.1: the extended system).
    ///
    /// # Errors
    /// [`AffineError`] if an exact test is undecided or there are too many inputs.
    pub fn affinize(&self) -> Result<Affinization, AffineError> {
        let mut system = self.clone();
        if system.inputs.len() > MAX_INPUTS {
            return Err(AffineError::TooManyInputs { inputs: system.inputs.len() });
        }
        // The highest derivative of each input that occurs (order 0: the input itself).
        let mut highest: Vec<(u32, Symbol)> = system.inputs.iter().map(|&s| (0, s)).collect();
        for d in &system.input_derivatives {
            if d.order > highest[d.input].0 {
                highest[d.input] = (d.order, d.symbol);
            }
        }
        let arguments: Vec<Symbol> = highest.iter().map(|h| h.1).collect();
        let pairs = system.curvature(&arguments)?;
        if system.input_derivatives.is_empty() {
            if pairs.is_empty() {
                let why = "the right-hand side is affine in the inputs as it stands".to_owned();
                return Ok(Affinization {
                    method: Method::None,
                    integrators: BTreeMap::new(),
                    input_change: Vec::new(),
                    system,
                    why,
                });
            }
            if let Some(done) = input_change(&mut system)? {
                return Ok(done);
            }
        }
        let extra = least_cover(arguments.len(), &pairs);
        Ok(augment(system, &highest, &extra, &pairs))
    }
}

/// A smallest set of inputs that touches every pair.
fn least_cover(inputs: usize, pairs: &[(usize, usize)]) -> Vec<bool> {
    let covers = |bits: usize| pairs.iter().all(|&(i, j)| bits >> i & 1 == 1 || bits >> j & 1 == 1);
    let best = (0..1usize << inputs).filter(|&b| covers(b)).min_by_key(|b| b.count_ones()).unwrap_or(0);
    (0..inputs).map(|i| best >> i & 1 == 1).collect()
}

/// A name that the system does not use yet.
fn fresh(pool: &mut Pool, wanted: &str) -> Symbol {
    let mut name = wanted.to_owned();
    while pool.find_symbol(&name).is_some() {
        name.push('_');
    }
    pool.symbol(&name)
}

/// Puts order + extra integrators in front of each input. The k-th derivative of `u` is called
/// `u` followed by k letters `d`.
fn augment(mut system: System, highest: &[(u32, Symbol)], extra: &[bool], pairs: &[(usize, usize)]) -> Affinization {
    let old_inputs = system.inputs.clone();
    let known: FxHashMap<(usize, u32), Symbol> =
        system.input_derivatives.iter().map(|d: &InputDerivative| ((d.input, d.order), d.symbol)).collect();
    let mut integrators = BTreeMap::new();
    let mut replace: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut new_inputs = Vec::new();
    let mut point_inputs = Vec::new();
    let zero = system.pool.int(0);
    let mut chains = Vec::new();
    for (i, &u) in old_inputs.iter().enumerate() {
        let count = highest[i].0 + u32::from(extra[i]);
        let base = system.pool.name(u).to_owned();
        let mut chain = vec![u];
        for k in 1..=count {
            let s = fresh(&mut system.pool, &format!("{base}{}", "d".repeat(k as usize)));
            if let Some(&old) = known.get(&(i, k)) {
                let (a, b) = (system.pool.sym(old), system.pool.sym(s));
                replace.insert(a, b);
            }
            chain.push(s);
        }
        if count > 0 {
            integrators.insert(base, count);
        }
        let value = system.point.as_ref().map_or(zero, |p| p.inputs[i]);
        new_inputs.push(chain[count as usize]);
        point_inputs.push(if count == 0 { value } else { zero });
        chains.push((chain, value));
    }
    system.dynamics = system.pool.substitute_all(&system.dynamics.clone(), &replace);
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    let outputs = system.pool.substitute_all(&outputs, &replace);
    for (o, e) in system.outputs.iter_mut().zip(outputs) {
        o.1 = e;
    }
    let mut point_states = system.point.take().map(|p| p.states);
    for (chain, value) in chains {
        for (k, pair) in chain.windows(2).enumerate() {
            system.states.push(pair[0]);
            let rate = system.pool.sym(pair[1]);
            system.dynamics.push(rate);
            if let Some(p) = &mut point_states {
                p.push(if k == 0 { value } else { zero });
            }
        }
    }
    system.point = point_states.map(|states| Point { states, inputs: point_inputs });
    system.input_derivatives.clear();
    system.inputs = new_inputs;
    system.name = format!("{}_affine", system.name);
    let why = augmentation_reason(&system, &old_inputs, highest, extra, pairs, &integrators);
    Affinization { method: Method::InputAugmentation, integrators, input_change: Vec::new(), system, why }
}

fn augmentation_reason(
    system: &System,
    old: &[Symbol],
    highest: &[(u32, Symbol)],
    extra: &[bool],
    pairs: &[(usize, usize)],
    integrators: &BTreeMap<String, u32>,
) -> String {
    let name = |i: usize| system.pool.name(old[i]);
    let mut parts = Vec::new();
    for (i, h) in highest.iter().enumerate() {
        if h.0 > 0 {
            parts.push(format!("{} enters up to its derivative of order {}", name(i), h.0));
        }
        if extra[i] {
            let with: Vec<&str> =
                pairs.iter().filter(|p| p.0 == i || p.1 == i).map(|p| name(if p.0 == i { p.1 } else { p.0 })).collect();
            let how = if pairs.contains(&(i, i)) {
                "enters nonlinearly".to_owned()
            } else {
                format!("multiplies {}", with.join(", "))
            };
            parts.push(format!("{} {how}", name(i)));
        }
    }
    let total: u32 = integrators.values().sum();
    let plural = if total == 1 { "" } else { "s" };
    format!(
        "{}; with {total} integrator{plural} the inputs {} enter affinely, and fewer do not suffice",
        parts.join(", "),
        system.input_names().join(", ")
    )
}

/// Terms (factor free of inputs, factor of inputs only); `None` if some factor mixes both.
fn separate(
    pool: &mut Pool,
    e: Expr,
    inputs: &FxHashSet<Symbol>,
    other: &FxHashSet<Symbol>,
) -> Option<Vec<(Expr, Expr)>> {
    let uses = pool.symbols_of(&[e]);
    let has_input = uses.iter().any(|s| inputs.contains(s));
    let has_state = uses.iter().any(|s| other.contains(s));
    let one = pool.int(1);
    match (has_input, has_state) {
        (false, _) => return Some(vec![(e, one)]),
        (true, false) if !matches!(pool.node(e), Node::Add(..) | Node::Mul(..)) => return Some(vec![(one, e)]),
        _ => {}
    }
    match pool.node(e) {
        Node::Add(a, b) => {
            let mut left = separate(pool, a, inputs, other)?;
            left.extend(separate(pool, b, inputs, other)?);
            Some(left)
        }
        Node::Mul(a, b) => product(pool, a, b, inputs, other),
        Node::Pow(a, k) => {
            let k = pool.integer(k).filter(|k| (2..=8).contains(k))?;
            let rest = pool.powi(a, k - 1);
            product(pool, a, rest, inputs, other)
        }
        _ => None,
    }
}

fn product(
    pool: &mut Pool,
    a: Expr,
    b: Expr,
    inputs: &FxHashSet<Symbol>,
    other: &FxHashSet<Symbol>,
) -> Option<Vec<(Expr, Expr)>> {
    let left = separate(pool, a, inputs, other)?;
    let right = separate(pool, b, inputs, other)?;
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

/// New inputs v = w(u), if the equations depend on u through at most as many functions as there are
/// inputs and these are independent. Checked by putting w(u) back.
fn input_change(system: &mut System) -> Result<Option<Affinization>, Undecided> {
    let inputs: FxHashSet<Symbol> = system.inputs.iter().copied().collect();
    let states: FxHashSet<Symbol> = system.states.iter().copied().collect();
    // (row, factor of the states, factor of the inputs)
    let mut terms: Vec<(usize, Expr, Expr)> = Vec::new();
    for (row, &e) in system.dynamics.clone().iter().enumerate() {
        let Some(list) = separate(&mut system.pool, e, &inputs, &states) else { return Ok(None) };
        terms.extend(list.into_iter().map(|(x, u)| (row, x, u)));
    }
    let mut functions: Vec<Expr> = Vec::new();
    for t in &mut terms {
        let (c, w) = unit_coefficient(&mut system.pool, t.2);
        t.1 = system.pool.mul(c, t.1);
        t.2 = w;
        if !system.pool.is_one(w) && !functions.contains(&w) {
            functions.push(w);
        }
    }
    if functions.is_empty() || functions.len() > system.inputs.len() {
        return Ok(None);
    }
    let jacobian = system.pool.jacobian(&functions, &system.inputs.clone());
    if system.pool.rank(&jacobian, &Bindings::default())?.rank < functions.len() {
        return Ok(None);
    }
    let old_inputs = system.inputs.clone();
    let mut new = Vec::new();
    for &w in &functions {
        let plain = old_inputs.iter().copied().find(|&u| system.pool.sym(u) == w);
        new.push(plain.unwrap_or_else(|| fresh(&mut system.pool, &format!("v{}", new.len() + 1))));
    }
    let mut dynamics = vec![system.pool.int(0); system.states.len()];
    for (row, x, w) in terms {
        let v = match functions.iter().position(|&f| f == w) {
            Some(i) => system.pool.sym(new[i]),
            None => system.pool.int(1),
        };
        let term = system.pool.mul(x, v);
        dynamics[row] = system.pool.add(dynamics[row], term);
    }
    // Putting w(u) back must give the old equations.
    let back: FxHashMap<Expr, Expr> = new.iter().zip(&functions).map(|(&v, &w)| (system.pool.sym(v), w)).collect();
    let restored = system.pool.substitute_all(&dynamics, &back);
    let mut check = system.clone();
    check.dynamics = restored.iter().zip(&system.dynamics.clone()).map(|(&a, &b)| check.pool.sub(a, b)).collect();
    check.outputs.clear();
    for e in check.switched_form().dynamics {
        if !is_zero(&mut check.pool, e)? {
            return Ok(None);
        }
    }
    let outputs_use_inputs =
        system.outputs.iter().any(|(_, e)| system.pool.symbols_of(&[*e]).iter().any(|s| inputs.contains(s)));
    if outputs_use_inputs {
        return Ok(None);
    }
    let at: FxHashMap<Expr, Expr> = match &system.point {
        Some(p) => old_inputs.iter().zip(&p.inputs).map(|(&u, &v)| (system.pool.sym(u), v)).collect(),
        None => FxHashMap::default(),
    };
    let values = system.pool.substitute_all(&functions, &at);
    if let Some(p) = &mut system.point {
        p.inputs = values;
    }
    system.dynamics = dynamics;
    system.inputs.clone_from(&new);
    let pairs: Vec<(String, Expr)> =
        new.iter().zip(&functions).map(|(&v, &w)| (system.pool.name(v).to_owned(), w)).collect();
    let shown: Vec<String> = pairs
        .iter()
        .filter(|(v, w)| *v != system.pool.text(*w))
        .map(|(v, w)| format!("{v} = {}", system.pool.text(*w)))
        .collect();
    let why = format!(
        "the equations depend on the inputs through {} independent function{}: {}",
        functions.len(),
        if functions.len() == 1 { "" } else { "s" },
        shown.join(", ")
    );
    let mut done = system.clone();
    done.name = format!("{}_affine", system.name);
    Ok(Some(Affinization {
        method: Method::InputChange,
        integrators: BTreeMap::new(),
        input_change: pairs,
        system: done,
        why,
    }))
}

/// Splits a numeric coefficient off a product: (number, rest).
fn unit_coefficient(pool: &mut Pool, e: Expr) -> (Expr, Expr) {
    match pool.node(e) {
        Node::Mul(a, b) if pool.number(a).is_some() => (a, b),
        Node::Num(_) => {
            let one = pool.int(1);
            (e, one)
        }
        _ => (pool.int(1), e),
    }
}
