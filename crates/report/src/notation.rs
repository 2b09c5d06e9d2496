//! Formulas of models, laid out.

use bracketry_symbolic::{Expr, Notation};
use bracketry_system::System;

/// An expression of a model, derivatives of its inputs with dots.
pub(crate) fn rate(system: &System, e: Expr) -> Notation {
    system.pool.notation(e).with_symbols(&|name| {
        let d = system.input_derivatives.iter().find(|d| system.symbol_name(d.symbol) == name)?;
        Some(Notation::symbol(system.symbol_name(system.inputs[d.input])).dotted(d.order))
    })
}
