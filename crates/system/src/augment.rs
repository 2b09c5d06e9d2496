//! Integrators in front of inputs.

use std::collections::BTreeMap;

use bracketry_symbolic::{Expr, Symbol};
use rustc_hash::FxHashMap;

use crate::candidate::{Candidate, Method};
use crate::input_change::fresh;
use crate::new_input::{AtPoint, NewInput};
use crate::range::Range;
use crate::reason::{AffineReason, Nonlinearity};
use crate::system::{InputDerivative, Point, System};

/// What is known of the inputs of a system before it is made affine.
pub(crate) struct Arguments {
    /// The highest derivative of each input that occurs (order 0: the input itself), and its symbol.
    pub(crate) highest: Vec<(u32, Symbol)>,
    /// The pairs of these (i ≤ j) in which the right-hand side is not affine.
    pub(crate) pairs: Vec<(usize, usize)>,
}

impl Arguments {
    /// States that integrators add, one for each order and one more for each of `extra`.
    pub(crate) fn states_added(&self, extra: &[bool]) -> usize {
        self.highest.iter().zip(extra).map(|(h, &e)| h.0 as usize + usize::from(e)).sum()
    }
}

/// Puts order + extra integrators in front of each input, except that those of `taken` become the highest derivative
/// that occurs. The k-th derivative of `u` is called `u` followed by k letters `d`.
pub(crate) fn augment(original: &System, arguments: &Arguments, extra: &[bool], taken: &[bool]) -> Candidate {
    let mut system = original.clone();
    let old_inputs = system.inputs.clone();
    let known: FxHashMap<(usize, u32), Symbol> =
        system.input_derivatives.iter().map(|d: &InputDerivative| ((d.input, d.order), d.symbol)).collect();
    let mut integrators = BTreeMap::new();
    let mut replace: FxHashMap<Expr, Expr> = FxHashMap::default();
    let mut new_inputs = Vec::new();
    let mut point_inputs = Vec::new();
    let zero = system.pool.int(0);
    let mut chains = Vec::new();
    let mut derivatives = Vec::new();
    for (i, &u) in old_inputs.iter().enumerate() {
        let count = arguments.highest[i].0 + u32::from(extra[i]);
        let base = system.pool.name(u).to_owned();
        let mut chain = vec![u];
        for k in 1..=count {
            if taken[i] && k < count {
                continue;
            }
            let s = fresh(&mut system.pool, &format!("{base}{}", "d".repeat(k as usize)));
            if let Some(&old) = known.get(&(i, k)) {
                let (a, b) = (system.pool.sym(old), system.pool.sym(s));
                replace.insert(a, b);
            }
            if let Some(unit) = original.quantities.unit_of_derivative(&base, k) {
                let name = system.pool.name(s).to_owned();
                system.quantities.set_unit(&name, unit);
            }
            chain.push(s);
        }
        let value = system.point.as_ref().map_or(zero, |p| p.inputs[i]);
        new_inputs.push(chain.last().copied().unwrap_or(u));
        point_inputs.push(if count == 0 { value } else { zero });
        if taken[i] {
            continue;
        }
        if count > 0 {
            integrators.insert(base, count);
            derivatives.extend(chain[1..].iter().map(|&s| (s, i)));
        }
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
    system.name = format!("{}_affine", original.name);
    let any_taken = taken.contains(&true);
    let (method, why) = if any_taken {
        (Method::InputChange, taken_reason(original, arguments, taken))
    } else {
        (Method::InputAugmentation, reason(original, &system, arguments, extra, integrators.values().sum()))
    };
    let mut candidate = Candidate::new(method, why);
    candidate.added_states = system.states.len() - original.states.len();
    candidate.integrators = integrators;
    candidate.derivatives = derivatives;
    if any_taken {
        candidate.input_change = derivatives_as_inputs(&mut system, arguments, taken);
        candidate.independent_ranges = Some(true);
    }
    candidate.system = Some(system);
    candidate
}

/// The highest derivatives that become inputs.
fn derivatives_as_inputs(system: &mut System, arguments: &Arguments, taken: &[bool]) -> Vec<NewInput> {
    let at_point = if system.point.is_some() { AtPoint::Interior } else { AtPoint::Unknown };
    let names = system.input_names();
    let taken = names.into_iter().zip(&arguments.highest).zip(taken).filter(|(_, taken)| **taken);
    taken
        .map(|((name, highest), _)| {
            let function = system.pool.sym(highest.1);
            NewInput { name, function, values: Range::Onto, at_point }
        })
        .collect()
}

fn taken_reason(original: &System, arguments: &Arguments, taken: &[bool]) -> AffineReason {
    let derivatives = arguments
        .highest
        .iter()
        .zip(taken)
        .filter(|(_, t)| **t)
        .map(|(h, _)| original.pool.name(h.1).to_owned())
        .collect();
    AffineReason::LoneDerivatives { derivatives }
}

/// The inputs for which only one derivative occurs anywhere, not the input itself nor another of its derivatives.
pub(crate) fn lone_derivatives(system: &System, arguments: &Arguments) -> Vec<bool> {
    let mut all = system.dynamics.clone();
    all.extend(system.outputs.iter().map(|o| o.1));
    let used = system.pool.symbols_of(&all);
    (0..system.inputs.len())
        .map(|i| {
            let orders = system.input_derivatives.iter().filter(|d| d.input == i && used.contains(&d.symbol)).count();
            let curved = arguments.pairs.iter().any(|p| p.0 == i || p.1 == i);
            arguments.highest[i].0 > 0 && orders == 1 && !curved && !used.contains(&system.inputs[i])
        })
        .collect()
}

fn reason(original: &System, augmented: &System, arguments: &Arguments, extra: &[bool], total: u32) -> AffineReason {
    let name = |i: usize| original.pool.name(original.inputs[i]).to_owned();
    let mut causes = Vec::new();
    for (i, h) in arguments.highest.iter().enumerate() {
        let input = name(i);
        if h.0 > 0 {
            causes.push(Nonlinearity::Derivative { input: input.clone(), order: h.0 });
        }
        if extra[i] && arguments.pairs.contains(&(i, i)) {
            causes.push(Nonlinearity::Nonlinear { input });
        } else if extra[i] {
            let partners = arguments.pairs.iter().filter(|p| p.0 == i || p.1 == i);
            causes.push(Nonlinearity::Products {
                input,
                with: partners.map(|p| name(if p.0 == i { p.1 } else { p.0 })).collect(),
            });
        }
    }
    AffineReason::Integrators { causes, total, inputs: augmented.input_names() }
}
