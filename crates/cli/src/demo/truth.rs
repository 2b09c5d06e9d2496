//! What the simulated plant really has that the published equations leave out, so that a wrong name is seen.

use bracketry::diagnose::{Cause, NamedCause};

/// Terms of contact over the whole footprint that the published equations lack, by the first of the parameters that the diagnosis
/// gives them. In first principles (docs/plate.md) the load is `g cos θ + y θ'' + 2 y' θ' − h θ'²`.
const TERMS: [&str; 9] = [
    // Friction acts against the slip, in proportion to the load.
    "coupling_vx_vy",
    "load_vx",
    "inertia_load_vx_vy_theta_rate_vx",
    "inertia_load_vy_theta_rate_vy",
    "inertia_load_theta_squared_vy",
    // y θ'² and h θ'' in y''.
    "inertia_y_theta_squared_vy",
    "inertia_theta_acceleration_vy",
    // The printed torque has the other sign; friction of the footprint against the spin, which takes part in the slip.
    "scale_w",
    "spin_ratio_w",
];

/// Whether the plant has what a diagnosis of the published equations names; none where it gives a term no name.
pub(super) fn is_in_plant(cause: &NamedCause) -> Option<bool> {
    let first = cause.parameters.first().map(|(first, _)| first.as_str());
    (cause.name != Cause::UnknownTerm).then(|| first.is_some_and(|first| TERMS.contains(&first)))
}
