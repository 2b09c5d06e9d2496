//! Energy of an object on the plate and the power that the plate feeds into it.

use super::derivation::flat_contact;
use crate::PlateError;
use bracketry_system::System;

/// Stored energy and the power of the contact forces, as expressions in the names of a model, its definitions included. Both
/// are per mass and in the inertial frame.
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
/// equations and their integration ([`Balance`](bracketry_sim::Balance)). The thickness resists tilting as that of a uniform prism, `Sc = h²/3`.
///
/// # Errors
/// [`PlateError::NoDefinition`] if the model does not define `fx`, `fy` and `torque`.
///
/// ```
/// use bracketry_plate::{Object, reduced};
/// use bracketry_plate::model::{Terms, energy};
/// let system = reduced(&Object::REFERENCE, 0.3, Terms::default()).unwrap();
/// assert!(energy(&system).unwrap().stored.contains("w^2"));
/// ```
pub fn energy(system: &System) -> Result<Energy, PlateError> {
    let forces = [("fx", "fx"), ("fy", "fy"), ("n", "torque")];
    for (_, name) in forces {
        if !system.definitions.iter().any(|(defined, _)| defined == name) {
            return Err(PlateError::NoDefinition { name });
        }
    }
    let mut flat = flat_contact();
    // The names of the derivation are those of the model but for the forces, rates of the inputs and the thickness.
    let rates = [("Xdd", "der(X, 2)"), ("Xd", "der(X)"), ("thetadd", "der(theta, 2)"), ("thetad", "der(theta)")];
    let names = forces.into_iter().chain(rates).chain([("Sc", "(h^2/3)")]);
    let names = names.map(|(symbol, name)| (flat.pool.var(symbol), flat.pool.var(name))).collect();
    let [stored, power] = [flat.energy, flat.contact_power].map(|e| {
        let named = flat.pool.substitute(e, &names);
        flat.pool.text(named)
    });
    Ok(Energy { stored, power })
}
