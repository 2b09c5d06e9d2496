//! Making a system affine in its inputs: recognition, and the search for the change that adds the fewest states.

use std::collections::BTreeMap;

use bracketry_symbolic::{Bindings, Expr, Pool, Symbol, Undecided, ZeroTest};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::augment::{Arguments, augment, lone_derivatives};
use crate::candidate::{Candidate, Method};
use crate::feedback::by_rows;
use crate::input_change::{Checks, apply};
use crate::lowering::{Transformation, lowered};
use crate::new_input::NewInput;
use crate::new_state::NewState;
use crate::range_note::RangeNote;
use crate::reason::{AffineError, AffineReason, MAX_INPUTS, Rejection};
use crate::separation::separated;
use crate::system::System;

/// x' = drift(x) + Σ fields_i(x) u_i.
#[derive(Clone)]
pub struct AffineForm {
    /// The pool of the system, and of the expressions.
    pub pool: Pool,
    /// One expression per state.
    pub drift: Vec<Expr>,
    /// One vector field per input.
    pub fields: Vec<Vec<Expr>>,
}

/// A system made affine in its inputs, and how.
#[derive(Clone, Debug)]
pub struct Affinization {
    /// What was done.
    pub method: Method,
    /// Integrators in front of each input that got any.
    pub integrators: BTreeMap<String, u32>,
    /// Each new input, in order, where there are any.
    pub input_change: Vec<NewInput>,
    /// New states that replace old ones.
    pub coordinate_change: Vec<NewState>,
    /// For new inputs and a model with a point: whether the old inputs reach a whole neighborhood of the new
    /// ones' values there because the Jacobian of w has full rank. If not, see [`Affinization::interior_at_point`].
    pub regular_at_point: Option<bool>,
    /// For new inputs and a model with a point: whether the values of the new inputs there are interior to the convex
    /// hull of all values that they take together; `None` where that was not established (or nothing was changed).
    /// Unless it is `Some(true)`, conclusions from small inputs of both signs do not transfer from the affine system
    /// to the original one.
    pub interior_at_point: Option<bool>,
    /// For new inputs and a model with a point: whether they take, together, all values near those at the point, so that any
    /// small feedback of them can be realized; `None` where that was not established (or nothing was changed).
    pub covers_at_point: Option<bool>,
    /// Where the ranges of the new inputs say less than those of the old ones.
    pub range_notes: Vec<RangeNote>,
    /// The affine system.
    pub system: System,
    /// The reason.
    pub why: AffineReason,
    /// All candidates, accepted ones first, by added states and then by simplicity; the one taken among them.
    pub candidates: Vec<Candidate>,
}

/// Sets of inputs for which integrators together with new inputs are tried.
const MAX_SETS: usize = 60;

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
    pub fn affine_form(&self) -> Result<Option<AffineForm>, Undecided> {
        let mut system = self.clone();
        if !self.input_derivatives.is_empty() || !system.curvature(&self.inputs)?.is_empty() {
            return Ok(None);
        }
        let mut pool = system.pool;
        let zero = pool.int(0);
        let at_zero: FxHashMap<Expr, Expr> = self.inputs.iter().map(|&s| (pool.sym(s), zero)).collect();
        let drift = pool.substitute_all(&self.dynamics, &at_zero);
        let mut fields = Vec::new();
        for &u in &self.inputs {
            let column: Vec<Expr> = self.dynamics.iter().map(|&e| pool.diff(e, u)).collect();
            fields.push(pool.substitute_all(&column, &at_zero));
        }
        Ok(Some(AffineForm { pool, drift, fields }))
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

    /// The highest derivative of each input that occurs, and where these enter nonlinearly.
    fn input_arguments(&mut self) -> Result<Arguments, Undecided> {
        let mut highest: Vec<(u32, Symbol)> = self.inputs.iter().map(|&s| (0, s)).collect();
        for d in &self.input_derivatives {
            if d.order > highest[d.input].0 {
                highest[d.input] = (d.order, d.symbol);
            }
        }
        let symbols: Vec<Symbol> = highest.iter().map(|h| h.1).collect();
        Ok(Arguments { pairs: self.curvature(&symbols)?, highest })
    }

    /// Makes the system affine in its inputs by the candidate that adds the fewest states: as written if possible, else by
    /// new inputs v = w(u) or v = w(x, u), else by the least number of integrators in front of inputs
    /// (Nijmeijer and van der Schaft 1990, sec. 6.1: the extended system), if need be together with new inputs for the
    /// others.
    ///
    /// A system that uses derivatives of inputs keeps its states and the chain of derivatives of each input; further
    /// candidates with fewer states are listed. New inputs that depend on the state are not taken where they are
    /// singular at the model's point.
    ///
    /// # Errors
    /// [`AffineError`] if an exact test is undecided or there are too many inputs.
    pub fn affinize(&self) -> Result<Affinization, AffineError> {
        let (mut chosen, mut others) = self.search()?;
        for candidate in std::iter::once(&mut chosen).chain(&mut others) {
            candidate.transfer_ranges(self);
            candidate.transfer_delays(self);
        }
        let system = match chosen.system.clone() {
            Some(system) => system,
            None => self.clone(),
        };
        chosen.chosen = true;
        let mut affinization = Affinization {
            method: chosen.method,
            integrators: chosen.integrators.clone(),
            input_change: chosen.input_change.clone(),
            coordinate_change: chosen.coordinate_change.clone(),
            regular_at_point: chosen.regular_at_point,
            interior_at_point: chosen.interior_at_point,
            covers_at_point: chosen.covers_at_point,
            range_notes: chosen.range_notes.clone(),
            system,
            why: chosen.why.clone(),
            candidates: std::iter::once(chosen).chain(others).collect(),
        };
        affinization.candidates.sort_by_key(rank);
        Ok(affinization)
    }

    /// The candidate that is taken, and all others.
    fn search(&self) -> Result<(Candidate, Vec<Candidate>), AffineError> {
        let mut system = self.clone();
        let arguments = system.input_arguments()?;
        let derivatives = !system.input_derivatives.is_empty();
        if !derivatives && arguments.pairs.is_empty() {
            let mut c = Candidate::new(Method::None, AffineReason::Affine);
            c.system = Some(system);
            return Ok((c, Vec::new()));
        }
        let extra = least_cover(system.inputs.len(), &arguments.pairs)?;
        let none = vec![false; extra.len()];
        let integrators = augment(&system, &arguments, &extra, &none);
        let mut others = changes(&system, &arguments, &extra);
        if derivatives {
            let lone = lone_derivatives(&system, &arguments);
            if lone.contains(&true) {
                others.push(augment(&system, &arguments, &extra, &lone));
            }
            others.extend(lower_orders(&system, arguments.states_added(&extra)));
            return Ok((integrators, others));
        }
        others.sort_by_key(rank);
        let fit = |c: &Candidate| {
            let regular = c.regular_at_point != Some(false) || c.interior_at_point == Some(true);
            c.system.as_ref().is_some_and(|s| regular || !uses_states(s, &c.input_change))
        };
        Ok(match others.iter().position(fit) {
            Some(k) => {
                let chosen = others.remove(k);
                others.push(integrators);
                (chosen, others)
            }
            None => (integrators, others),
        })
    }
}

/// Whether a new input is a function of states also.
fn uses_states(system: &System, inputs: &[NewInput]) -> bool {
    let functions: Vec<Expr> = inputs.iter().map(|v| v.function).collect();
    system.pool.symbols_of(&functions).iter().any(|s| system.states.contains(s))
}

/// Accepted ones first, by added states, by what is changed, by the number of new inputs.
fn rank(c: &Candidate) -> (bool, usize, Method, usize, bool) {
    (!c.is_accepted(), c.added_states, c.method, c.input_change.len(), !c.chosen)
}

/// New inputs, with integrators in front of fewer inputs than `extra`: the accepted candidate with the fewest, and why
/// there is none without any.
fn changes(system: &System, arguments: &Arguments, extra: &[bool]) -> Vec<Candidate> {
    let most = extra.iter().filter(|e| **e).count();
    let mut curved: Vec<usize> = arguments.pairs.iter().flat_map(|p| [p.0, p.1]).collect();
    curved.sort_unstable();
    curved.dedup();
    let mut found = Vec::new();
    let mut tried = 0;
    for size in 0..most {
        for set in sets(&curved, size) {
            tried += 1;
            if tried > MAX_SETS {
                return found;
            }
            let mut with = vec![false; extra.len()];
            for i in set {
                with[i] = true;
            }
            match change_after(system, arguments, &with) {
                Ok(c) => {
                    found.push(c);
                    return found;
                }
                Err(why) if size == 0 => found.push(Candidate::new(Method::InputChange, AffineReason::Rejected(why))),
                Err(_) => {}
            }
        }
    }
    found
}

/// The subsets of `size` elements.
fn sets(of: &[usize], size: usize) -> Vec<Vec<usize>> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for &i in of {
        if all.len() > 100 * MAX_SETS {
            break;
        }
        let more: Vec<Vec<usize>> =
            all.iter().filter(|s| s.len() < size).map(|s| s.iter().copied().chain([i]).collect()).collect();
        all.extend(more);
    }
    all.retain(|s| s.len() == size);
    all
}

/// New inputs after integrators in front of some.
fn change_after(system: &System, arguments: &Arguments, with: &[bool]) -> Result<Candidate, Rejection> {
    let integrators = augment(system, arguments, with, &vec![false; with.len()]);
    let mut base = match &integrators.system {
        Some(s) if !integrators.integrators.is_empty() => s.clone(),
        _ => system.clone(),
    };
    let mut candidate = match separated(&mut base) {
        Ok(change) => apply(&base, change)?,
        Err(separate) => match by_rows(&mut base).and_then(|change| apply(&base, change)) {
            Ok(c) => c,
            Err(undecided @ Rejection::Undecided(_)) => return Err(undecided),
            Err(why) => return Err(if matches!(separate, Rejection::TooMany { .. }) { separate } else { why }),
        },
    };
    if let Some(s) = &mut candidate.system {
        s.name = format!("{}_affine", system.name);
    }
    if !integrators.integrators.is_empty() {
        let names = integrators.integrators.keys().cloned().collect();
        candidate.why = AffineReason::After { integrators: names, then: Box::new(candidate.why) };
        candidate.method = Method::InputAugmentation;
        candidate.added_states = integrators.added_states;
        candidate.integrators = integrators.integrators;
        candidate.derivatives = integrators.derivatives;
    }
    Ok(candidate)
}

/// New states with which fewer than `most` integrators do, one input after the other.
fn lower_orders(system: &System, most: usize) -> Vec<Candidate> {
    let mut rejected = Vec::new();
    let mut best = system.clone();
    let mut change = Transformation::identity(&mut best);
    let (mut least, mut checks) = (most, Checks::default());
    for input in 0..system.inputs.len() {
        let (mut current, mut so_far) = (best.clone(), change.clone());
        let mut trial = Checks { certificate: checks.certificate };
        let mut reason = None;
        while let Some(order) = current.input_derivatives.iter().filter(|d| d.input == input).map(|d| d.order).max() {
            match lowered(&current, &so_far, input, order, &mut trial) {
                Ok(next) => (current, so_far) = next,
                Err(why) => {
                    reason.get_or_insert(why);
                    break;
                }
            }
            match integrators_needed(&current) {
                Ok(needed) if needed < least => {
                    least = needed;
                    (best, change, reason) = (current.clone(), so_far.clone(), None);
                    checks.certificate = trial.certificate;
                }
                Ok(needed) => {
                    let states = so_far.states(&current.pool);
                    reason = Some(Rejection::NoFewerIntegrators { states, integrators: needed });
                }
                Err(why) => reason = Some(why.into()),
            }
        }
        if let Some(why) = reason {
            rejected.push(Candidate::new(Method::CoordinateChange, AffineReason::Rejected(why)));
        }
    }
    if least < most
        && let Ok(arguments) = best.input_arguments()
        && let Ok(extra) = least_cover(best.inputs.len(), &arguments.pairs)
    {
        let mut c = augment(&best, &arguments, &extra, &vec![false; extra.len()]);
        c.method = Method::CoordinateChange;
        c.coordinate_change = change.states(&best.pool);
        c.why = AffineReason::NewStates { states: c.coordinate_change.clone(), integrators: least, instead_of: most };
        c.certificate = checks.certificate;
        if let Some(s) = &mut c.system {
            s.name = format!("{}_affine", system.name);
        }
        rejected.push(c);
    }
    rejected
}

fn integrators_needed(system: &System) -> Result<usize, AffineError> {
    let mut s = system.clone();
    let arguments = s.input_arguments()?;
    let extra = least_cover(s.inputs.len(), &arguments.pairs)?;
    Ok(arguments.states_added(&extra))
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
