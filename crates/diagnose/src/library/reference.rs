//! What a more complete model has and this one lacks.

use bracketry_symbolic::{Expr, Func, Node, Pool, Symbol};
use bracketry_system::System;
use rustc_hash::FxHashMap;

use super::builder::{Builder, amplitude, dissipation};
use super::physical_terms::physical_terms;
use super::structure::{Kind, is_constant};
use super::terms::{slope, summands};
use crate::effect::{Cause, Coefficient, Effect, Role};
use crate::error::DiagnoseError;
use crate::settings::LibrarySettings;

/// The additive terms that the equations of a more complete model have and those of this one lack, each with an amplitude
/// that is 0 in this model and 1 in the other.
///
/// Equations are compared state by state, by name, multiplied out; parameters of the same name and value stay symbols, all
/// others are numbers. Where the reference has dry friction against the direction of the slip and the model has it on each
/// axis, that difference is one effect of its own ([`Cause::FrictionCoupling`]), and the rest is compared with the coupled
/// model. Where terms share a parameter with the model, as `k sqrt(h)` in place of `k h`, all differences of the equation
/// together are one effect more. Terms are classified by what they contain: friction against the rate of a rotation that has none is
/// [`Cause::YawFriction`] (all terms of an equation together), products with rates or with derivatives of inputs are
/// [`Cause::InertialCoupling`], laws of the own rate or position have their names; the rest is [`Cause::UnknownTerm`].
///
/// # Errors
/// [`DiagnoseError::UnknownName`] if the reference has none of the model's states; otherwise as [`super::candidates`].
pub fn reference_candidates(system: &System, reference: &System) -> Result<Vec<Effect>, DiagnoseError> {
    let shared: Vec<String> = system.state_names().into_iter().filter(|n| reference.state_index(n).is_some()).collect();
    if shared.is_empty() {
        return Err(DiagnoseError::UnknownName {
            what: "state of the reference",
            name: reference.state_names().join(", "),
            known: system.state_names().join(", "),
        });
    }
    // Without records nothing is tried.
    let mut builder = Builder::new(system, &[], &LibrarySettings::default());
    let mut theirs = reference.clone();
    let directed = !theirs.set_valued_form().unit_vectors.is_empty();
    if directed {
        couple(&mut builder)?;
    }
    let wanted = differences(&mut builder, theirs, &shared);
    for (row, difference) in wanted {
        let mut yaw = None;
        let parts = summands(&builder.system.pool, difference);
        // Alone, a term with a parameter of the model cannot take the place of another one with it, as `k sqrt(h)` of `k h`.
        if parts.len() > 1 && share_parameters(&mut builder, row, &parts) {
            add(&mut builder, Cause::UnknownTerm, row, difference)?;
        }
        for term in physical_terms(&mut builder.system, &builder.structure, difference) {
            let cause = classify(&mut builder, row, term);
            if cause == Cause::YawFriction {
                yaw = Some(match yaw {
                    Some(sum) => builder.system.pool.add(sum, term),
                    None => term,
                });
                continue;
            }
            add(&mut builder, cause, row, term)?;
        }
        if let Some(term) = yaw {
            add(&mut builder, Cause::YawFriction, row, term)?;
        }
    }
    Ok(builder.effects)
}

/// Whether the reference has a term in place of one of the model, with a parameter of that.
fn share_parameters(builder: &mut Builder, row: usize, terms: &[Expr]) -> bool {
    let system = &mut builder.system;
    let own = system.pool.expand(system.dynamics[row]);
    let own = summands(&system.pool, own);
    let (replaced, new): (Vec<Expr>, Vec<Expr>) = terms.iter().partition(|&&t| {
        own.iter().any(|&o| {
            let sum = system.pool.add(o, t);
            let sum = system.pool.simplify(sum);
            system.pool.is_zero(sum)
        })
    });
    let with = |all: &[Expr], p: Symbol| all.iter().any(|&t| system.pool.depends_on(t, p));
    let shared = |p: Symbol| with(&replaced, p) && with(&new, p) && !own.iter().all(|&t| system.pool.depends_on(t, p));
    system.parameters.iter().any(|p| shared(p.symbol))
}

fn add(builder: &mut Builder, cause: Cause, row: usize, term: Expr) -> Result<(), DiagnoseError> {
    let v = builder.state(row);
    let k = builder.name("missing", &v);
    let about = format!("1: the equation of {v} has this term of the reference; 0: it does not");
    let c = match cause {
        Cause::YawFriction => dissipation(k.clone(), "1", about),
        _ => amplitude(k.clone(), "1", about),
    };
    // All of the term: where a model sticks that should slide, a small part of it changes nothing.
    let c = Coefficient { trials: vec![1.0], ..c };
    builder.along(cause, row, &[(row, term)], &k, vec![c])
}

/// Makes the effect that couples dry friction over its axes, and the change in the model that the rest is compared with.
fn couple(builder: &mut Builder) -> Result<(), DiagnoseError> {
    builder.coupling()?;
    let Some(effect) = builder.effects.last().filter(|e| e.cause == Cause::FrictionCoupling) else { return Ok(()) };
    let effect = effect.clone();
    let mut coupled = builder.system.clone();
    effect.apply(&mut coupled)?;
    let mut map = FxHashMap::default();
    for c in effect.coefficients.iter().filter(|c| c.role == Role::Amplitude) {
        let (name, one) = (coupled.pool.var(&c.name), coupled.pool.int(1));
        map.insert(name, one);
    }
    let rows = coupled.dynamics.clone();
    coupled.dynamics = coupled.pool.substitute_all(&rows, &map);
    coupled.parameters.truncate(builder.system.parameters.len());
    builder.system = coupled;
    Ok(())
}

/// Reference minus model, by row of the model.
fn differences(builder: &mut Builder, mut theirs: System, shared: &[String]) -> Vec<(usize, Expr)> {
    let ours = &mut builder.system;
    // Parameters that both have at the same value stay symbols.
    let same: Vec<String> = ours
        .parameters
        .iter()
        .filter(|p| {
            let name = ours.symbol_name(p.symbol);
            theirs.parameters.iter().any(|q| theirs.symbol_name(q.symbol) == name && q.value == p.value)
        })
        .map(|p| ours.symbol_name(p.symbol).to_owned())
        .collect();
    let numbers = |system: &mut System| {
        let others: Vec<_> = system
            .parameters
            .iter()
            .filter(|p| !same.iter().any(|n| n == system.symbol_name(p.symbol)))
            .map(|p| (p.symbol, p.value.clone()))
            .collect();
        let mut map = FxHashMap::default();
        for (symbol, value) in others {
            let (s, v) = (system.pool.sym(symbol), system.pool.rational(value));
            map.insert(s, v);
        }
        let rows = system.dynamics.clone();
        system.pool.substitute_all(&rows, &map)
    };
    let their_rows = numbers(&mut theirs);
    let our_rows = numbers(ours);
    let table = theirs.pool.export(&their_rows);
    // What one pool exports, another can import.
    let Ok(imported) = ours.pool.import(&table) else { return Vec::new() };
    let mut all = Vec::new();
    for name in shared {
        let (Some(row), Some(other)) = (ours.state_index(name), theirs.state_index(name)) else { continue };
        let difference = ours.pool.sub(imported[other], our_rows[row]);
        let difference = ours.pool.expand(difference);
        if ours.pool.is_zero(difference) {
            continue;
        }
        all.push((row, difference));
    }
    all
}

/// The name of a term by what it contains.
fn classify(builder: &mut Builder, row: usize, term: Expr) -> Cause {
    let system = &mut builder.system;
    let used = system.pool.symbols_of(&[term]);
    let coordinate = builder.structure.coordinates.iter().find(|c| c.rate == row);
    let rates: Vec<Symbol> = builder.structure.coordinates.iter().map(|c| system.states[c.rate]).collect();
    let own = system.states[row];
    let derivatives = used.iter().any(|&s| {
        !system.states.contains(&s) && !system.inputs.contains(&s) && !system.parameters.iter().any(|p| p.symbol == s)
    });
    if let Some(c) = coordinate
        && c.kind == Kind::Angle
        && !c.has_dry_friction
        && used.contains(&own)
        && opposes(&mut system.pool, term, own)
    {
        return Cause::YawFriction;
    }
    let moving: Vec<Symbol> =
        used.iter().copied().filter(|s| !system.parameters.iter().any(|p| p.symbol == *s)).collect();
    if derivatives || moving.iter().filter(|s| rates.contains(s)).count() > 1 {
        return Cause::InertialCoupling;
    }
    let position = coordinate.and_then(|c| c.position).map(|q| system.states[q]);
    match moving[..] {
        [] => Cause::ConstantBias,
        [s] if s == own => own_rate(&mut system.pool, term, own),
        [s] if Some(s) == position => {
            let slope = slope(&mut system.pool, term, s);
            if is_constant(system, slope) { Cause::LinearStiffness } else { Cause::UnknownTerm }
        }
        [s] if rates.contains(&s) => Cause::InertialCoupling,
        _ => Cause::UnknownTerm,
    }
}

/// Whether a term changes its sign with a rate: friction against it.
fn opposes(pool: &mut Pool, term: Expr, rate: Symbol) -> bool {
    let v = pool.sym(rate);
    let minus = pool.neg(v);
    let mirrored = pool.substitute(term, &std::iter::once((v, minus)).collect());
    let sum = pool.add(term, mirrored);
    let sum = pool.simplify(sum);
    pool.is_zero(sum)
}

/// The name of a term that depends on the own rate only.
fn own_rate(pool: &mut Pool, term: Expr, rate: Symbol) -> Cause {
    let nodes = pool.reachable(&[term]);
    let has = |wanted: Func| nodes.iter().any(|&e| matches!(pool.node(e), Node::Call(f, _) if f == wanted));
    match (has(Func::Exp), has(Func::Sign), has(Func::Abs)) {
        (true, true, _) => Cause::StribeckFriction,
        (false, true, false) => Cause::CoulombFriction,
        (false, _, true) if opposes(pool, term, rate) => Cause::QuadraticDrag,
        _ if opposes(pool, term, rate) => {
            let slope = slope(pool, term, rate);
            if pool.depends_on(slope, rate) { Cause::UnknownTerm } else { Cause::ViscousFriction }
        }
        _ => Cause::UnknownTerm,
    }
}
