//! Formulas of models, laid out.

use bracketry_symbolic::{Expr, Notation, Pool};
use bracketry_system::System;

/// An expression of a model, derivatives of its inputs with dots.
pub(crate) fn rate(system: &System, e: Expr) -> Notation {
    rate_of(system, &system.pool, e)
}

/// The same for an expression of another pool with the symbols of the model.
pub(crate) fn rate_of(system: &System, pool: &Pool, e: Expr) -> Notation {
    pool.notation(e).with_symbols(&|name| {
        let d = system.input_derivatives.iter().find(|d| system.symbol_name(d.symbol) == name)?;
        Some(Notation::symbol(system.symbol_name(system.inputs[d.input])).dotted(d.order))
    })
}
