//! Points at which the equations have values and do not jump.

use bracketry_symbolic::{Expr, Function, Irregular};
use bracketry_system::{Point, System};
use rustc_hash::FxHashMap;

use crate::error::Error;

/// Whether dynamics and outputs have values at a point, and no function in them jumps there but those that switch modes.
///
/// # Errors
/// [`Error::NoValue`] and [`Error::Jumps`] with the function that has none.
pub(crate) fn regular_at(system: &mut System, point: &Point) -> Result<(), Error> {
    let mut at: FxHashMap<Expr, Expr> = FxHashMap::default();
    let values = system.states.iter().zip(&point.states).chain(system.inputs.iter().zip(&point.inputs));
    for (&s, &v) in values {
        at.insert(system.pool.sym(s), v);
    }
    for d in &system.input_derivatives {
        at.insert(system.pool.sym(d.symbol), system.pool.int(0));
    }
    for p in &system.parameters {
        at.insert(system.pool.sym(p.symbol), system.pool.rational(p.value.clone()));
    }
    let mut roots: Vec<Expr> = system.dynamics.clone();
    roots.extend(system.outputs.iter().map(|o| o.1));
    // As written, the equations have no value where these have none.
    roots.extend(&system.canceled);
    // Values such as that of the new input 1/u.
    roots.extend(point.states.iter().chain(&point.inputs));
    let found = system.pool.irregular_at(&roots, &at);
    let text = |e: Expr| {
        let hidden = if system.canceled.contains(&e) { ", which cancels in the equations," } else { "" };
        Function::new(&system.pool, e).text() + hidden
    };
    match found {
        None => Ok(()),
        Some(Irregular::NoValue(e)) => Err(Error::NoValue { what: text(e) }),
        Some(Irregular::Jump(e)) => Err(Error::Jumps { what: text(e) }),
    }
}
