//! Integrators in front of inputs.

use bracketry_system::{AffineError, System};

/// The model with integrators in front of the inputs whose derivatives it uses: what is steered.
///
/// # Errors
/// [`AffineError`] where these are not found.
pub fn own_inputs(system: &System) -> Result<System, AffineError> {
    if system.input_derivatives.is_empty() { Ok(system.clone()) } else { Ok(system.affinize()?.system) }
}
