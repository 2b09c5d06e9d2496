//! The equations of a model, set for readers: shorter where that is known to be the same, and with one notation for derivatives.

use bracketry_symbolic::{Expr, Node, Notation, Pool};
use bracketry_system::System;

use super::{escaped, symbol, table};
use crate::notation::rate_of;

/// Nodes, shared ones counted each time, beyond which expressions stay as they are: nobody reads them.
const LARGEST: f64 = 2000.0;

/// The equations of a model, set. Common factors are canceled, and `Xd` is set as the derivative that it is where X' = Xd.
pub fn equations(system: &System) -> String {
    let (mut pool, rates) = system.pool.extract(&system.dynamics);
    let name = format!("Equations of {}, {} states", system.name, system.states.len());
    let row = |(name, e): (String, Expr)| {
        let (left, right) = (derivative(system, &name, 1).mathml(), set(system, &mut pool, e));
        // What only says that one is the derivative of the other is in the notation.
        (left != right).then(|| vec![format!("{left} ="), right])
    };
    table(&name, &[], system.state_names().into_iter().zip(rates).filter_map(row))
}

/// Equations, parameters, and outputs of a model.
pub(super) fn model(system: &System) -> String {
    let mut out = equations(system);
    if !system.parameters.is_empty() {
        let rows = system.parameters.iter().map(|p| {
            let value = p.value.to_f64().value().to_string();
            let [unit, about] = [&p.unit, &p.about].map(|text| escaped(text.as_deref().unwrap_or_default()));
            vec![symbol(system.symbol_name(p.symbol)), value, unit, about]
        });
        out += &table("Parameters", &["parameter", "value", "unit", "about"], rows);
    }
    if !system.outputs.is_empty() {
        let expressions: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
        let (mut pool, expressions) = system.pool.extract(&expressions);
        let names = system.outputs.iter().map(|o| symbol(&o.0));
        let rows = names.zip(expressions).map(|(name, e)| vec![format!("{name} ="), set(system, &mut pool, e)]);
        out += &table("Outputs", &[], rows);
    }
    out
}

/// An expression, shorter where canceling makes it so.
fn set(system: &System, pool: &mut Pool, e: Expr) -> String {
    let short = if pool.tree_size(e) > LARGEST { e } else { pool.simplify(e) };
    // Where nothing cancels, the order in which it was written stays.
    let e = if mentions(pool, short) < mentions(pool, e) { short } else { e };
    rate_of(system, pool, e).with_symbols(&|name| integrated(system, name)).mathml()
}

/// How often symbols stand in an expression.
fn mentions(pool: &Pool, e: Expr) -> f64 {
    match pool.node(e) {
        _ if pool.tree_size(e) > LARGEST => f64::INFINITY,
        Node::Sym(_) => 1.0,
        node => node.operands().map(|o| mentions(pool, o)).sum(),
    }
}

/// The derivative of a state, of an order from 1.
fn derivative(system: &System, name: &str, order: u32) -> Notation {
    match origin(system, name) {
        Some((base, known)) => Notation::symbol(base).dotted(known + order),
        None => Notation::symbol(name).dotted(order),
    }
}

/// A name that stands for a derivative, with dots.
fn integrated(system: &System, name: &str) -> Option<Notation> {
    let (base, order) = origin(system, name)?;
    Some(Notation::symbol(base).dotted(order))
}

/// The state whose derivative a name stands for, and the order: X and 2 for Xdd where X' = Xd and Xd' = Xdd.
fn origin<'a>(system: &System, name: &'a str) -> Option<(&'a str, u32)> {
    let integrates = |from: &str, to: &str| {
        let state = system.states.iter().position(|s| system.symbol_name(*s) == from);
        let rate = state.map(|k| system.pool.node(system.dynamics[k]));
        matches!(rate, Some(Node::Sym(s)) if system.symbol_name(s) == to)
    };
    let (mut base, mut order) = (name, 0);
    while let Some(shorter) = base.strip_suffix('d').filter(|shorter| !shorter.is_empty() && integrates(shorter, base))
    {
        (base, order) = (shorter, order + 1);
    }
    (order > 0).then_some((base, order))
}
