//! The dry friction of a model, as what jumps in it.

use bracketry_symbolic::Expr;
use bracketry_system::{SwitchKind, System};

/// Names and arguments of the signs in a model. The exact flow treats these; kinks alone are smooth enough.
pub(super) fn jumps(system: &mut System) -> Vec<(String, Expr)> {
    let form = system.set_valued_form();
    let jumps = form.signs().iter().filter(|s| s.kind == SwitchKind::Jump);
    jumps.map(|s| (s.name.clone(), s.surface)).collect()
}

/// Whether a model has functions that jump, as friction does: signs, or unit vectors. Limits written with `min` and `max` have kinks alone.
pub(super) fn has_friction(system: &System) -> bool {
    let form = system.clone().set_valued_form();
    !form.unit_vectors.is_empty() || form.signs().iter().any(|s| s.kind == SwitchKind::Jump)
}
