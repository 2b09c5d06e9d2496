//! Energy of an object on the plate and the power that the plate feeds into it.

use crate::{PlateError, flat_contact};
use bracketry_system::System;

/// Stored energy and the power of the contact forces, as expressions in the names of a model. Both are per mass and in the
/// inertial frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Energy {
    /// Kinetic and potential energy in J/kg.
    pub stored: String,
    /// Power of load, pressure and friction on the object in W/kg.
    pub power: String,
}

/// Energy and power of a first-principles model ([`first_principles`](crate::first_principles),
/// [`reduced`](crate::reduced)) with all its terms: the rate of `stored` is `power`.
///
/// Both come from [`flat_contact`], not from the model's equations, so that their balance along a trajectory checks the
/// equations and their integration. The thickness resists tilting as that of a uniform prism, `Sc = h²/3`.
///
/// # Errors
/// [`PlateError::NoDefinition`] if the model does not define `fx`, `fy` and `torque`.
///
/// ```
/// use bracketry_plate::{Object, Terms, energy, reduced};
/// let system = reduced(&Object::REFERENCE, 0.3, Terms::default()).unwrap();
/// assert!(energy(&system).unwrap().stored.contains("w^2"));
/// ```
pub fn energy(system: &System) -> Result<Energy, PlateError> {
    let mut flat = flat_contact();
    // The names of the derivation are those of the model but for derivatives of the inputs, forces and thickness.
    let mut names: Vec<(&'static str, String)> = vec![
        ("Xdd", "der(X, 2)".into()),
        ("Xd", "der(X)".into()),
        ("thetadd", "der(theta, 2)".into()),
        ("thetad", "der(theta)".into()),
        ("Sc", "h^2/3".into()),
    ];
    for (symbol, name) in [("fx", "fx"), ("fy", "fy"), ("n", "torque")] {
        let defined = system.definitions.iter().find(|(n, _)| n == name).map(|(_, e)| *e);
        let force = defined.ok_or(PlateError::NoDefinition { name })?;
        names.push((symbol, system.pool.text(force)));
    }
    let placeholders = names.iter().map(|(symbol, text)| (flat.pool.var(symbol), flat.pool.var(&format!("({text})"))));
    let map = placeholders.collect();
    let both = [flat.energy, flat.contact_power];
    let [stored, power] = both.map(|e| {
        let named = flat.pool.substitute(e, &map);
        flat.pool.text(named)
    });
    Ok(Energy { stored, power })
}
