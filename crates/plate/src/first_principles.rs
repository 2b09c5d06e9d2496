//! Point contact with coupled dry friction, from first principles.

use crate::parameters::{exact, set_not_negative, set_positive};
use crate::{Friction, Object, PlateError};
use bracketry_system::symbolic::{Expr, Rational};
use bracketry_system::{Parameter, System};
use rustc_hash::FxHashMap;

const POINT: &str = include_str!("../../../models/plate_point.toml");

/// Which terms a model of the plate has. All are on by default; each off leaves its equation without that term.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "terms are independent of each other")]
pub struct Terms {
    /// `y θ'²` in `y''`.
    pub centrifugal: bool,
    /// `y θ''` in the load.
    pub euler: bool,
    /// `2 y' θ'` in the load.
    pub coriolis: bool,
    /// `h θ''` in `y''` and `h θ'²` in the load.
    pub thickness: bool,
    /// Friction against the slip; without, against each component of the slip on its own, by its sign.
    pub coupled: bool,
    /// Friction along x follows the load; without, it is that of the load `g`.
    pub load_along_x: bool,
    /// `Sxy θ'²` in the yaw.
    pub gyroscopic: bool,
    /// Torque of the friction along y, `−μ Sxy θ'' e_y`; of the reduced model only.
    pub torque_across: bool,
    /// Friction against the spin; of the reduced model only.
    pub yaw_friction: bool,
}

impl Default for Terms {
    fn default() -> Self {
        Self {
            centrifugal: true,
            euler: true,
            coriolis: true,
            thickness: true,
            coupled: true,
            load_along_x: true,
            gyroscopic: true,
            torque_across: true,
            yaw_friction: true,
        }
    }
}

impl Terms {
    /// The terms of the published model: of these only `y θ''` in the load.
    pub const PUBLISHED: Terms = Terms {
        centrifugal: false,
        euler: true,
        coriolis: false,
        thickness: false,
        coupled: false,
        load_along_x: false,
        gyroscopic: false,
        torque_across: false,
        yaw_friction: false,
    };

    /// The names of the terms in the model files, but for `coupled`, which is no factor.
    fn factors(self) -> [(&'static str, bool); 8] {
        [
            ("centrifugal", self.centrifugal),
            ("euler", self.euler),
            ("coriolis", self.coriolis),
            ("thickness", self.thickness),
            ("load_along_x", self.load_along_x),
            ("gyroscopic", self.gyroscopic),
            ("torque_across", self.torque_across),
            ("yaw_friction", self.yaw_friction),
        ]
    }
}

/// The first-principles model of an object that touches the plate in one point under its centre of mass:
///
/// ```text
/// x'' = −X'' − μ N e_x          N = g cos θ + y θ'' + 2 y' θ' − h θ'²       e = (x', y')/|(x', y')|
/// y'' = −g sin θ + y θ'² + h θ'' − μ N e_y
/// I φ'' = Sxy θ'²
/// ```
///
/// with states `x, y, phi, vx, vy, w` and inputs `X, theta` (`models/plate_point.toml`; derived by
/// [`flat_contact`](crate::flat_contact)). At rest `e` is any vector of the unit disk. The equations hold while `N > 0`.
///
/// # Errors
/// [`PlateError`] for numbers without meaning and for a polygon whose principal axes are turned against its own.
///
/// ```
/// use bracketry_plate::{Friction, Object, Terms, first_principles};
/// let system = first_principles(&Object::REFERENCE, &Friction::Coulomb { mu: 0.3 }, Terms::default()).unwrap();
/// assert_eq!(system.state_names(), ["x", "y", "phi", "vx", "vy", "w"]);
/// ```
pub fn first_principles(object: &Object, friction: &Friction, terms: Terms) -> Result<System, PlateError> {
    let mut system = with_terms("plate_point.toml", POINT, object, terms)?;
    friction.validate()?;
    match *friction {
        Friction::Coulomb { mu } => set_not_negative(&mut system, "mu", mu)?,
        Friction::StaticLevel { .. } => return Err(PlateError::NoStaticLevel),
        Friction::Stribeck { mu, mu_static, velocity } => {
            set_not_negative(&mut system, "mu", mu)?;
            add_parameter(&mut system, "mu_static", mu_static, "1", "friction coefficient at rest")?;
            add_parameter(&mut system, "velocity", velocity, "m/s", "Stribeck velocity")?;
            replace(&mut system, &[("mu", "mu + (mu_static - mu)*exp(-(vx^2 + vy^2)/velocity^2)")])?;
        }
        Friction::Viscous { mu, coefficient } => {
            set_not_negative(&mut system, "mu", mu)?;
            add_parameter(&mut system, "viscosity", coefficient, "s/m", "force per load and speed")?;
            replace(&mut system, &[("mu", "mu + viscosity*sqrt(vx^2 + vy^2)")])?;
        }
        Friction::Anisotropic { mu_along, mu_across } => {
            add_parameter(&mut system, "mu_along", mu_along, "1", "friction coefficient of slip along x")?;
            add_parameter(&mut system, "mu_across", mu_across, "1", "friction coefficient of slip along y")?;
            let mut laws = vec![("mu", "1")];
            if terms.coupled && mu_along > 0.0 && mu_across > 0.0 {
                laws.push(("ex", "mu_along*mu_along*vx/sqrt((mu_along*vx)^2 + (mu_across*vy)^2)"));
                laws.push(("ey", "mu_across*mu_across*vy/sqrt((mu_along*vx)^2 + (mu_across*vy)^2)"));
            } else {
                laws.extend([("ex", "mu_along*sign(vx)"), ("ey", "mu_across*sign(vy)")]);
            }
            replace(&mut system, &laws)?;
            let mu = system.pool.symbol("mu");
            system.parameters.retain(|p| p.symbol != mu);
        }
    }
    if !terms.coupled {
        replace(&mut system, PER_AXIS)?;
    }
    Ok(system)
}

/// Friction of each axis on its own.
pub(crate) const PER_AXIS: &[(&str, &str)] = &[("ex", "sign(vx)"), ("ey", "sign(vy)")];

/// A model file with the second moments and the height of the object and the terms that are factors.
pub(crate) fn with_terms(file: &str, text: &str, object: &Object, terms: Terms) -> Result<System, PlateError> {
    object.validate()?;
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

/// Gives the model another parameter.
fn add_parameter(
    system: &mut System,
    name: &'static str,
    value: f64,
    unit: &str,
    about: &str,
) -> Result<(), PlateError> {
    let value = exact(value).ok_or(PlateError::NegativeNumber { name, value })?;
    let symbol = system.pool.symbol(name);
    let (unit, about) = (Some(unit.to_owned()), Some(about.to_owned()));
    system.parameters.push(Parameter { symbol, value, min: Some(Rational::ZERO), max: None, unit, about });
    Ok(())
}

/// Puts expressions in the place of definitions and parameters.
pub(crate) fn replace(system: &mut System, replaced: &[(&'static str, &str)]) -> Result<(), PlateError> {
    let mut map: FxHashMap<Expr, Expr> = FxHashMap::default();
    for &(name, text) in replaced {
        let defined = system.definitions.iter().find(|(n, _)| n == name).map(|(_, e)| *e);
        let old = defined.unwrap_or_else(|| system.pool.var(name));
        let new = system.pool.parse(text).map_err(|_| PlateError::BadLaw { name })?;
        map.insert(old, new);
    }
    let mut all = system.dynamics.clone();
    all.extend(system.definitions.iter().map(|(_, e)| *e));
    let all = system.pool.substitute_all(&all, &map);
    let (dynamics, definitions) = all.split_at(system.dynamics.len());
    system.dynamics = dynamics.to_vec();
    for ((_, e), new) in system.definitions.iter_mut().zip(definitions) {
        *e = *new;
    }
    Ok(())
}
