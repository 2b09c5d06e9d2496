//! Laws of dry friction between the object and the plate.

use crate::PlateError;
use serde::{Deserialize, Serialize};

/// Friction force per unit of normal load, as a function of the slip velocity relative to the plate.
///
/// Every law has the form `f = −p · coefficient(s) · D² v / s`, `s = |D v|`, with the load `p` and the diagonal matrix `D` of
/// [`Friction::weights`] (the identity but for [`Friction::Anisotropic`]). At `v = 0` the force is set-valued: every `f` with
/// `|D⁻¹ f| ≤ p · static_coefficient()`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Friction {
    /// Coulomb: `mu`, whatever the speed.
    Coulomb {
        /// Friction coefficient.
        mu: f64,
    },
    /// Coulomb with a higher level at rest.
    StaticLevel {
        /// Coefficient of sliding.
        mu: f64,
        /// Coefficient of sticking, at least `mu`.
        mu_static: f64,
    },
    /// Stribeck: `mu + (mu_static − mu) exp(−(s/velocity)²)`, Bo and Pavelescu (1982) with exponent 2.
    Stribeck {
        /// Coefficient of fast sliding.
        mu: f64,
        /// Coefficient at rest, at least `mu`.
        mu_static: f64,
        /// Stribeck velocity in m/s.
        velocity: f64,
    },
    /// Coulomb with an elliptic limit surface whose axes are those of the plate, and maximum dissipation:
    /// `f = −p M² v / |M v|`, `M = diag(mu_along, mu_across)`. The force is not opposite to the slip in general.
    Anisotropic {
        /// Coefficient of slip along the plate's x axis.
        mu_along: f64,
        /// Coefficient of slip along the plate's y axis.
        mu_across: f64,
    },
    /// Coulomb and viscous friction: `mu + coefficient · s`.
    Viscous {
        /// Coefficient at vanishing speed.
        mu: f64,
        /// Force per load and speed, in s/m.
        coefficient: f64,
    },
}

impl Friction {
    /// Checks the numbers of the law.
    ///
    /// # Errors
    /// [`PlateError::NegativeNumber`] for a coefficient that is negative or not finite, [`PlateError::BadNumber`] for a
    /// Stribeck velocity that is not positive, [`PlateError::StaticBelowSliding`] if `mu_static < mu`.
    ///
    /// ```
    /// use bracketry_plate::Friction;
    /// let error = Friction::Coulomb { mu: -0.1 }.validate().unwrap_err();
    /// assert_eq!(error.to_string(), "mu = -0.1 must be a finite number, zero or positive");
    /// ```
    pub fn validate(&self) -> Result<(), PlateError> {
        match *self {
            Self::Coulomb { mu } => not_negative("mu", mu),
            Self::StaticLevel { mu, mu_static } => levels(mu, mu_static),
            Self::Stribeck { mu, mu_static, velocity } => {
                if !(velocity.is_finite() && velocity > 0.0) {
                    return Err(PlateError::BadNumber { name: "velocity", value: velocity });
                }
                levels(mu, mu_static)
            }
            Self::Anisotropic { mu_along, mu_across } => {
                not_negative("mu_along", mu_along)?;
                not_negative("mu_across", mu_across)
            }
            Self::Viscous { mu, coefficient } => {
                not_negative("mu", mu)?;
                not_negative("coefficient", coefficient)
            }
        }
    }

    /// Force per load while sliding at the weighted speed `s = |D v| > 0` in m/s; at `s = 0` its limit.
    pub fn coefficient(&self, speed: f64) -> f64 {
        match *self {
            Self::Coulomb { mu } | Self::StaticLevel { mu, .. } => mu,
            Self::Stribeck { mu, mu_static, velocity } => mu + (mu_static - mu) * (-(speed / velocity).powi(2)).exp(),
            Self::Anisotropic { mu_along, mu_across } => mu_along.max(mu_across),
            Self::Viscous { mu, coefficient } => mu + coefficient * speed,
        }
    }

    /// Greatest force per load of a contact at rest, along the axis of greatest friction.
    pub fn static_coefficient(&self) -> f64 {
        match *self {
            Self::StaticLevel { mu_static, .. } => mu_static,
            Self::Coulomb { .. } | Self::Stribeck { .. } | Self::Anisotropic { .. } | Self::Viscous { .. } => {
                self.coefficient(0.0)
            }
        }
    }

    /// The part of [`Friction::coefficient`] that grows in proportion to the speed, in s/m, and at most by the whole of it:
    /// the step of the contact takes it implicitly.
    pub(crate) fn viscosity(&self) -> f64 {
        match *self {
            Self::Viscous { coefficient, .. } => coefficient,
            Self::Coulomb { .. } | Self::StaticLevel { .. } | Self::Stribeck { .. } | Self::Anisotropic { .. } => 0.0,
        }
    }

    /// Diagonal of `D`, plate axes: friction along each axis relative to the greater one.
    pub fn weights(&self) -> [f64; 2] {
        match *self {
            Self::Anisotropic { mu_along, mu_across } if mu_along.max(mu_across) > 0.0 => {
                let greater = mu_along.max(mu_across);
                [mu_along / greater, mu_across / greater]
            }
            _ => [1.0, 1.0],
        }
    }

    /// Force per load on a contact that slides with the velocity `v` (m/s, plate axes). Zero at `v = 0`, where the force is
    /// set-valued.
    ///
    /// ```
    /// use bracketry_plate::Friction;
    /// let force = Friction::Coulomb { mu: 0.5 }.force([0.3, -0.4]);
    /// assert!((force[0] + 0.3).abs() < 1e-15 && (force[1] - 0.4).abs() < 1e-15);
    /// ```
    pub fn force(&self, v: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = self.weights();
        let speed = (dx * v[0]).hypot(dy * v[1]);
        if speed == 0.0 {
            return [0.0, 0.0];
        }
        let factor = -self.coefficient(speed) / speed;
        [factor * dx * dx * v[0], factor * dy * dy * v[1]]
    }
}

fn levels(mu: f64, mu_static: f64) -> Result<(), PlateError> {
    not_negative("mu", mu)?;
    not_negative("mu_static", mu_static)?;
    if mu_static < mu {
        return Err(PlateError::StaticBelowSliding { mu, mu_static });
    }
    Ok(())
}

fn not_negative(name: &'static str, value: f64) -> Result<(), PlateError> {
    if value.is_finite() && value >= 0.0 { Ok(()) } else { Err(PlateError::NegativeNumber { name, value }) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const LAWS: [Friction; 5] = [
        Friction::Coulomb { mu: 0.3 },
        Friction::StaticLevel { mu: 0.3, mu_static: 0.4 },
        Friction::Stribeck { mu: 0.3, mu_static: 0.4, velocity: 0.05 },
        Friction::Anisotropic { mu_along: 0.2, mu_across: 0.4 },
        Friction::Viscous { mu: 0.3, coefficient: 0.5 },
    ];

    fn directions() -> impl Iterator<Item = [f64; 2]> {
        (0..24).map(|i| (f64::from(i) * 15f64.to_radians()).sin_cos()).map(|(s, c)| [c, s])
    }

    #[test]
    fn friction_never_feeds_energy_into_the_slip() {
        for law in LAWS {
            law.validate().unwrap();
            for [c, s] in directions() {
                let force = law.force([0.1 * c, 0.1 * s]);
                assert!(force[0] * c + force[1] * s < -0.1);
            }
        }
    }

    #[test]
    fn anisotropic_friction_dissipates_the_most_that_its_limit_ellipse_allows() {
        let (along, across) = (0.2, 0.4);
        let law = Friction::Anisotropic { mu_along: along, mu_across: across };
        for v in directions() {
            let force = law.force(v);
            assert!(((force[0] / along).powi(2) + (force[1] / across).powi(2) - 1.0).abs() < 1e-12);
            let power = force[0] * v[0] + force[1] * v[1];
            for other in directions() {
                assert!(power <= -along * other[0] * v[0] - across * other[1] * v[1] + 1e-12);
            }
        }
    }

    #[test]
    fn slip_along_an_axis_meets_the_coefficient_of_that_axis() {
        let law = Friction::Anisotropic { mu_along: 0.2, mu_across: 0.4 };
        assert!((law.force([0.5, 0.0])[0] + 0.2).abs() < 1e-15);
        assert!((law.force([0.0, -0.5])[1] - 0.4).abs() < 1e-15);
        // A direction without friction carries none.
        let groove = Friction::Anisotropic { mu_along: 0.0, mu_across: 0.4 };
        assert_eq!(groove.force([0.5, 0.0]), [0.0, 0.0]);
    }

    #[test]
    fn the_level_at_rest_is_the_limit_of_stribeck_but_above_that_of_a_static_level() {
        let stribeck = Friction::Stribeck { mu: 0.3, mu_static: 0.4, velocity: 0.05 };
        assert_eq!(stribeck.static_coefficient(), stribeck.coefficient(0.0));
        assert!((stribeck.coefficient(0.05) - (0.3 + 0.1 / 1f64.exp())).abs() < 1e-15);
        let level = Friction::StaticLevel { mu: 0.3, mu_static: 0.4 };
        assert_eq!((level.coefficient(0.0), level.static_coefficient()), (0.3, 0.4));
        let viscous = Friction::Viscous { mu: 0.3, coefficient: 0.5 };
        assert_eq!((viscous.static_coefficient(), viscous.coefficient(0.2)), (0.3, 0.4));
    }

    #[test]
    fn numbers_without_meaning_are_refused_by_name() {
        let refused = |law: Friction| law.validate().unwrap_err().to_string();
        assert!(refused(Friction::Coulomb { mu: f64::NAN }).starts_with("mu = NaN"));
        assert!(refused(Friction::Anisotropic { mu_along: 0.1, mu_across: -1.0 }).starts_with("mu_across = -1"));
        assert!(refused(Friction::Viscous { mu: 0.1, coefficient: f64::INFINITY }).starts_with("coefficient = inf"));
        let stribeck = Friction::Stribeck { mu: 0.1, mu_static: 0.2, velocity: 0.0 };
        assert!(refused(stribeck).starts_with("velocity = 0"));
        let level = Friction::StaticLevel { mu: 0.3, mu_static: 0.2 };
        assert_eq!(level.validate(), Err(PlateError::StaticBelowSliding { mu: 0.3, mu_static: 0.2 }));
    }
}
