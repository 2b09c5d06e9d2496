//! Point contact with coupled dry friction, from first principles.

use super::parameters::{set_not_negative, set_positive};
use super::terms::Terms;
use crate::{Friction, Object, PlateError};
use bracketry_system::symbolic::{Expr, Func, Rational};
use bracketry_system::{StaticLevel, System};
use rustc_hash::FxHashMap;

const COULOMB: &str = include_str!("../../models/plate_point.toml");
const STATIC_LEVEL: &str = include_str!("../../models/plate_point_static_level.toml");
const STRIBECK: &str = include_str!("../../models/plate_point_stribeck.toml");
const ANISOTROPIC: &str = include_str!("../../models/plate_point_anisotropic.toml");
const VISCOUS: &str = include_str!("../../models/plate_point_viscous.toml");

/// The first-principles model of an object that touches the plate in one point under its center of mass:
///
/// ```text
/// x'' = −X'' − μ N e_x          N = g cos θ + y θ'' + 2 y' θ' − h θ'²       e = (x', y')/|(x', y')|
/// y'' = −g sin θ + y θ'² + h θ'' − μ N e_y
/// I φ'' = Sxy θ'²
/// ```
///
/// with states `x, y, phi, vx, vy, w` and inputs `X, theta` (`models/plate_point.toml`, for other laws than Coulomb's
/// `models/plate_point_static_level.toml`, `…_stribeck.toml`, `…_viscous.toml`, `…_anisotropic.toml`; derived by
/// [`flat_contact`](crate::model::flat_contact)). At rest `e` is any vector of the unit disk. The equations hold while `N > 0`.
///
/// # Errors
/// [`PlateError`] for numbers without meaning and for a polygon whose principal axes are rotated against its own.
///
/// ```
/// use bracketry_plate::{Friction, Object, first_principles};
/// use bracketry_plate::model::Terms;
/// let system = first_principles(&Object::REFERENCE, &Friction::Coulomb { mu: 0.3 }, Terms::default()).unwrap();
/// assert_eq!(system.state_names(), ["x", "y", "phi", "vx", "vy", "w"]);
/// ```
pub fn first_principles(object: &Object, friction: &Friction, terms: Terms) -> Result<System, PlateError> {
    friction.validate()?;
    let (file, text, numbers) = match *friction {
        Friction::Coulomb { mu } => ("plate_point.toml", COULOMB, vec![("mu", mu)]),
        Friction::StaticLevel { mu, mu_static } => {
            ("plate_point_static_level.toml", STATIC_LEVEL, vec![("mu", mu), ("mu_static", mu_static)])
        }
        Friction::Stribeck { mu, mu_static, velocity } => {
            let numbers = vec![("mu", mu), ("mu_static", mu_static), ("velocity", velocity)];
            ("plate_point_stribeck.toml", STRIBECK, numbers)
        }
        Friction::Anisotropic { mu_along, mu_across } => {
            let numbers = vec![("mu_along", mu_along), ("mu_across", mu_across)];
            ("plate_point_anisotropic.toml", ANISOTROPIC, numbers)
        }
        Friction::Viscous { mu, coefficient } => {
            ("plate_point_viscous.toml", VISCOUS, vec![("mu", mu), ("viscosity", coefficient)])
        }
    };
    let mut system = with_terms(file, text, object, terms)?;
    for (name, value) in numbers {
        set_not_negative(&mut system, name, value)?;
    }
    if let Friction::StaticLevel { mu, .. } = *friction {
        // The model knows the level at rest relative to that of sliding.
        set_positive(&mut system, "mu", mu)?;
    }
    // Friction of one axis alone is coupled with nothing.
    let one_axis = matches!(*friction, Friction::Anisotropic { mu_along, mu_across } if mu_along.min(mu_across) == 0.0);
    if one_axis || !terms.coupled {
        act_per_axis(&mut system);
    }
    Ok(system)
}

/// A model file with the second moments and the height of the object and the terms that are factors.
pub(super) fn with_terms(file: &str, text: &str, object: &Object, terms: Terms) -> Result<System, PlateError> {
    object.validate()?;
    object.stands_evenly()?;
    let angle = object.shape.principal_angle();
    if angle != 0.0 {
        return Err(PlateError::TurnedAxes { angle });
    }
    let mut system = System::parse(file, text)?;
    let (sa, sb) = object.shape.second_moments();
    set_positive(&mut system, "Sa", sa)?;
    set_positive(&mut system, "Sb", sb)?;
    set_not_negative(&mut system, "h", object.height)?;
    for (name, on) in terms.factors() {
        system.set_parameter(name, if on { Rational::ONE } else { Rational::ZERO });
    }
    Ok(system)
}

/// Takes friction against each component of the slip on its own: `sign(vx)`, `sign(vy)` in the place of the direction.
pub(super) fn act_per_axis(system: &mut System) {
    let defined: FxHashMap<String, Expr> = system.definitions.iter().cloned().collect();
    let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
    for (direction, component) in [("ex", "vx"), ("ey", "vy")] {
        let velocity = system.pool.var(component);
        let sign = system.pool.call(Func::Sign, velocity);
        map.extend(defined.get(direction).map(|&e| (e, sign)));
    }
    // Two signs are no direction: the second moment along the slip becomes the mean one.
    if let (Some(&along), Some(&inertia)) = (defined.get("See"), defined.get("I")) {
        let half = system.pool.ratio(1, 2);
        map.insert(along, system.pool.mul(half, inertia));
    }
    // The level at rest is now that of each sign.
    let levels = std::mem::take(&mut system.static_levels);
    let each = |level: StaticLevel| {
        let ratio = level.ratio;
        level.components.into_iter().map(move |c| StaticLevel { components: vec![c], ratio })
    };
    system.static_levels = levels.into_iter().flat_map(each).collect();
    let mut all = system.dynamics.clone();
    all.extend(system.definitions.iter().map(|(_, e)| *e));
    let all = system.pool.substitute_all(&all, &map);
    let (dynamics, definitions) = all.split_at(system.dynamics.len());
    system.dynamics = dynamics.to_vec();
    for ((_, e), new) in system.definitions.iter_mut().zip(definitions) {
        *e = *new;
    }
}
