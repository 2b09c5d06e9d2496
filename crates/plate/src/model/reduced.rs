//! The reduced yaw-friction equations of an object on the plate.

use super::first_principles::{act_per_axis, with_terms};
use super::parameters::set_not_negative;
use super::terms::Terms;
use crate::{Object, PlateError};
use bracketry_system::System;

const REDUCED: &str = include_str!("../../models/plate_reduced.toml");

/// The area contact reduced to an ordinary differential equation: the motion of the center of mass as in
/// [`first_principles`](crate::first_principles) with Coulomb friction, and the yaw torque that the pressure and the spin give:
///
/// ```text
/// I φ'' = −μ θ''(Sxy e_y − Syy e_x) + Sxy θ'² − μ g cos θ S_ee φ'/√(v² + I φ'²/4)
/// ```
///
/// with the direction of the slip `e` and the second moment along it, `S_ee`; states `x, y, phi, vx, vy, w`, inputs `X, theta`
/// (`models/plate_reduced.toml`). The first part is the torque of uniform slip under the pressure of a thin body, the last is
/// exact to first order in the spin and saturates where the object turns faster than it slides.
///
/// # Errors
/// [`PlateError`] for numbers without meaning and for a polygon whose principal axes are rotated against its own.
///
/// ```
/// use bracketry_plate::{Object, reduced};
/// use bracketry_plate::model::Terms;
/// let without_spin_friction = Terms { yaw_friction: false, ..Terms::default() };
/// let system = reduced(&Object::REFERENCE, 0.3, without_spin_friction).unwrap();
/// assert_eq!(system.input_names(), ["X", "theta"]);
/// ```
pub fn reduced(object: &Object, mu: f64, terms: Terms) -> Result<System, PlateError> {
    let mut system = with_terms("plate_reduced.toml", REDUCED, object, terms)?;
    set_not_negative(&mut system, "mu", mu)?;
    if !terms.coupled {
        act_per_axis(&mut system);
    }
    Ok(system)
}
