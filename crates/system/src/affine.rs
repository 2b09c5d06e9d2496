//! Making a system affine in its inputs: recognition, change of inputs, integrators in front of inputs.

use std::collections::BTreeMap;

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol, Undecided, ZeroTest};
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;

use crate::input_change::input_change;
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

/// A new input v = w(u).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewInput {
    /// Its name.
    pub name: String,
    /// The function w of the old inputs.
    pub function: Expr,
    /// The values that w can take where these are limited, such as `v1 ≥ 0`.
    pub range: Option<String>,
}

/// A system made affine in its inputs, and how.
#[derive(Clone, Debug)]
pub struct Affinization {
    /// What was done.
    pub method: Method,
    /// Integrators in front of each input that got any.
    pub integrators: BTreeMap<String, u32>,
    /// For [`Method::InputChange`]: each new input, in order.
    pub input_change: Vec<NewInput>,
    /// For [`Method::InputChange`] and a model with a point: whether the old inputs reach a whole neighbourhood of the new
    /// ones' values there (the Jacobian of w has full rank). If not, statements about small inputs at the point do not
    /// carry over from the affine system to the original one.
    pub regular_at_point: Option<bool>,
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
    /// More inputs multiply each other than the search over subsets takes.
    #[error(
        "{inputs} inputs multiply each other, too many for the search over integrators (at most {MAX_INPUTS}): write some of \
         them as states with a new input each"
    )]
    TooManyInputs {
        /// Number of such inputs.
        inputs: usize,
    },
}

const MAX_INPUTS: usize = 16;
pub(crate) fn is_zero(pool: &mut Pool, e: Expr) -> Result<bool, Undecided> {
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
                    regular_at_point: None,
                    system,
                    why,
                });
            }
            // Where a test stays undecided there are still the integrators.
            if let Ok(Some(done)) = input_change(&system) {
                return Ok(done);
            }
        }
        let extra = least_cover(arguments.len(), &pairs)?;
        Ok(augment(system, &highest, &extra, &pairs))
    }
}

/// A smallest set of inputs that touches every pair.
fn least_cover(inputs: usize, pairs: &[(usize, usize)]) -> Result<Vec<bool>, AffineError> {
    let mut chosen: Vec<bool> = (0..inputs).map(|i| pairs.contains(&(i, i))).collect();
    let open: Vec<(usize, usize)> = pairs.iter().copied().filter(|&(i, j)| !chosen[i] && !chosen[j]).collect();
    let mut involved: Vec<usize> = open.iter().flat_map(|&(i, j)| [i, j]).collect();
    involved.sort_unstable();
    involved.dedup();
    if involved.len() > MAX_INPUTS {
        return Err(AffineError::TooManyInputs { inputs: involved.len() });
    }
    let holds = |bits: usize, i: usize| involved.iter().position(|&k| k == i).is_some_and(|k| bits >> k & 1 == 1);
    let covers = |bits: usize| open.iter().all(|&(i, j)| holds(bits, i) || holds(bits, j));
    let best = (0..1usize << involved.len()).filter(|&b| covers(b)).min_by_key(|b| b.count_ones()).unwrap_or(0);
    for (k, &i) in involved.iter().enumerate() {
        chosen[i] |= best >> k & 1 == 1;
    }
    Ok(chosen)
}

/// A name that the system does not use yet.
pub(crate) fn fresh(pool: &mut Pool, wanted: &str) -> Symbol {
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
    Affinization {
        method: Method::InputAugmentation,
        integrators,
        input_change: Vec::new(),
        regular_at_point: None,
        system,
        why,
    }
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
        "{}; with {total} integrator{plural} the inputs {} enter affinely, with fewer integrators they do not",
        parts.join(", "),
        system.input_names().join(", ")
    )
}
