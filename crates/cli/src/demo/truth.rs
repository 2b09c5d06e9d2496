//! What the simulated plant really has that the published equations leave out, so that a wrong name is seen.

use bracketry::diagnose::{Cause, NamedCause};

/// Terms of contact over the whole footprint that the published equations lack, as the diagnosis calls them: the cause and the
/// first of its parameters. In first principles (docs/plate.md) the load is `g cos θ + y θ'' + 2 y' θ' − h θ'²`.
const TERMS: [(Cause, &str); 9] = [
    // Friction acts against the slip, in proportion to the load.
    (Cause::FrictionCoupling, "coupling_vx_vy"),
    (Cause::InertialCoupling, "load_vx"),
    (Cause::InertialCoupling, "inertia_load_vx_vy_theta_rate_vx"),
    (Cause::InertialCoupling, "inertia_load_vy_theta_rate_vy"),
    (Cause::InertialCoupling, "inertia_load_theta_squared_vy"),
    // y θ'² and h θ'' in y''.
    (Cause::InertialCoupling, "inertia_y_theta_squared_vy"),
    (Cause::InertialCoupling, "inertia_theta_acceleration_vy"),
    // The printed torque has the other sign; friction of the footprint against the spin.
    (Cause::InertialCoupling, "scale_w"),
    (Cause::YawFriction, "spin_w"),
];

/// Whether the plant has what a diagnosis of the published equations names.
pub(super) fn is_in_plant(cause: &NamedCause) -> bool {
    cause.parameters.first().is_some_and(|(first, _)| TERMS.contains(&(cause.name, first.as_str())))
}
