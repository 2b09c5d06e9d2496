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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_inputs_have_dots() {
        let text = "states = ['x']\ninputs = ['u', 'uu']\n[dynamics]\nx = 'der(u)^2 + der(uu, 3)*sin(u)'";
        let system = System::parse("m", text).unwrap();
        let set = rate(&system, system.dynamics[0]).latex();
        assert!(set.contains("\\dot{u}^{2}") && set.contains("{\\mathrm{uu}}^{(3)}"), "{set}");
        assert!(!set.contains("der"), "{set}");
    }
}
