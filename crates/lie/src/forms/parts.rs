//! Systems within a decomposition, and the zeros that make them systems of their own.

use std::ops::Range;

use bracketry_symbolic::{Bindings, Expr, Symbol};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use crate::algebra::span::vanishes;
use crate::forms::frame::Frame;
use crate::forms::normal_form::{NormalForm, Part, PartKind};
use crate::forms::obstacle::{Obstacle, Stop};
use crate::modes::parameter_bindings;

/// Makes sure that the rates of some states are free of the others, given by number, and of `inputs`, and seen to be.
pub(crate) fn independent_of(
    form: &mut NormalForm,
    states: Range<usize>,
    others: Range<usize>,
    inputs: &[Symbol],
) -> Result<(), Stop> {
    let others: Vec<Symbol> = form.system.states[others].iter().chain(inputs).copied().collect();
    let bindings = parameter_bindings(&form.system);
    for k in states {
        let rate = form.system.dynamics[k];
        let rate = free_of(&mut form.system, rate, &others, &bindings);
        let name = || form.coordinates.0[k].0.clone();
        form.system.dynamics[k] = rate.ok_or_else(|| Stop::Unknown(Obstacle::Unconfirmed { name: name() }))?;
    }
    Ok(())
}

impl Frame {
    /// Adds the system of some states, of which it is known that the others do not enter; with the outputs that they give, and
    /// the inputs named.
    pub(crate) fn add_part(&self, form: &mut NormalForm, kind: PartKind, states: Range<usize>, inputs: &[Symbol]) {
        let mut system = form.system.clone();
        let outside: Vec<Symbol> = (0..system.states.len())
            .filter(|k| !states.contains(k))
            .map(|k| system.states[k])
            .chain(system.inputs.iter().copied().filter(|u| !inputs.contains(u)))
            .collect();
        let bindings = parameter_bindings(&system);
        let mut outputs = Vec::new();
        for (name, h) in std::mem::take(&mut system.outputs) {
            outputs.extend(free_of(&mut system, h, &outside, &bindings).map(|h| (name, h)));
        }
        system.name = format!("{}_{}", self.system.name, kind.name());
        system.outputs = outputs;
        system.dynamics = system.dynamics[states.clone()].to_vec();
        system.states = system.states[states.clone()].to_vec();
        let mut kept = system.inputs.iter().map(|u| inputs.contains(u));
        if let Some(point) = &mut system.point {
            point.states = point.states[states].to_vec();
            point.inputs.retain(|_| kept.next().unwrap_or(true));
        }
        system.inputs.retain(|u| inputs.contains(u));
        system.input_ranges.retain(|r| inputs.contains(&r.input));
        system.input_delays.retain(|d| inputs.contains(&d.input));
        form.parts.push(Part { kind, system });
    }
}

/// The expression without the symbols, if it does not depend on them.
pub(crate) fn free_of(system: &mut System, e: Expr, symbols: &[Symbol], bindings: &Bindings) -> Option<Expr> {
    let pool = &mut system.pool;
    let inside: Vec<Symbol> = symbols.iter().copied().filter(|&s| pool.depends_on(e, s)).collect();
    if inside.is_empty() {
        return Some(e);
    }
    for &s in &inside {
        let d = pool.diff(e, s);
        if !vanishes(pool, d, bindings) {
            return None;
        }
    }
    // It is the same for all of their values, of which small integers are tried.
    (0..4).find_map(|k| {
        let map: FxHashMap<Expr, Expr> = inside.iter().map(|&s| (pool.sym(s), pool.int(k))).collect();
        let at = pool.substitute(e, &map);
        let at = pool.simplify(at);
        let difference = pool.sub(at, e);
        vanishes(pool, difference, bindings).then_some(at)
    })
}
