//! What the simulated plant really has that the published equations leave out, so that a wrong name or value is seen.

use std::f64::consts::FRAC_1_SQRT_2;

use bracketry::diagnose::{Cause, NamedCause};
use bracketry::plate::{Object, Shape};

/// A parameter of a term that the plant has.
struct InPlant {
    /// Its value there, where that has a closed form for the object.
    value: Option<f64>,
}

/// What the plant has of a parameter of the diagnosis; none where it lacks the term. In first principles (docs/plate.md) the load is `g cos θ + y θ'' + 2 y' θ' − h θ'²`, and friction acts against the slip, in
/// proportion to it.
fn term_of_plant(parameter: &str, object: &Object) -> Option<InPlant> {
    let h = object.height;
    // The pressure of a disk has the second moment r²/4 along each axis.
    let disk = |value: fn(f64) -> f64| match object.shape {
        Shape::Disk { radius } => Some(value(radius)),
        _ => None,
    };
    let value = match parameter {
        // Of the friction, and of the load that it is in proportion to; y θ'² in y''.
        "coupling_vx_vy" | "load_vx" | "inertia_y_theta_squared_vy" => Some(1.0),
        "inertia_load_vx_vy_theta_rate_vx" | "inertia_load_vy_theta_rate_vy" => Some(2.0),
        "inertia_load_theta_squared_vy" => Some(-h),
        // h θ'' in y''.
        "inertia_theta_acceleration_vy" => Some(h),
        // The printed torque has the other sign.
        "scale_w" => Some(-2.0),
        // To second order in the spin, it counts in the slip with the length r/2; the radius of gyration is r/√2.
        "spin_ratio_w" => disk(|_| FRAC_1_SQRT_2),
        "spin_gyration_w" => disk(|radius| radius * FRAC_1_SQRT_2),
        _ => return None,
    };
    Some(InPlant { value })
}

/// The value that a parameter of the diagnosis has in the plant, where it has one.
pub(super) fn value_in_plant(parameter: &str, object: &Object) -> Option<f64> {
    term_of_plant(parameter, object)?.value
}

/// Whether the plant has what a diagnosis of the published equations names; none where it gives a term no name.
pub(super) fn is_in_plant(cause: &NamedCause, object: &Object) -> Option<bool> {
    let mut parameters = cause.parameters.iter().map(|(name, _)| name);
    (cause.name != Cause::UnknownTerm).then(|| parameters.next().is_some_and(|n| term_of_plant(n, object).is_some()))
}
