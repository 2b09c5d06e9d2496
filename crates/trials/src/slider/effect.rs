//! Effects that are hidden in synthetic logs.

use bracketry_diagnose::Cause;
use rand::RngExt;
use rand::rngs::StdRng;

/// An effect that the slider has and its model lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SliderEffect {
    /// A force −c v.
    Viscous,
    /// Friction that falls with speed: −F exp(−(v/s)²) sign v on top of Coulomb's.
    Stribeck,
    /// A constant force: the rail is not level.
    Tilt,
    /// The force arrives late.
    InputDelay,
    /// A force −c |v| v.
    QuadraticDrag,
    /// Coulomb friction that is larger in one direction.
    FrictionAsymmetry,
    /// A force −k x.
    LinearStiffness,
    /// A force −k x³.
    CubicStiffness,
    /// The force follows the command with a first-order lag.
    ActuatorLag,
    /// A sine in time.
    PeriodicDisturbance,
    /// Coulomb friction that varies along the rail: −F sin(k x) sign v.
    PositionDependentFriction,
    /// A force that varies along the rail: F sin(k x).
    Cogging,
    /// A force −c v³.
    CubicDrag,
    /// Part of the mass hangs on a spring with a damper.
    ElasticMass,
    /// Friction of bristles that bend before they slip, in place of Coulomb's (Dahl 1968; Canudas de Wit, Olsson, Åström, and
    /// Lischinsky 1995, with constant g).
    BristleFriction,
    /// Coulomb friction that grows toward a higher level while the slider warms up.
    WarmingFriction,
    /// The drive's force is limited, which the log does not show.
    ForceLimit,
}

/// What an effect does to the plant's equations. `{a}` stands for its strength, `{b}` for its shape; x and v are the slider's states,
/// u the force that it receives, M and F its mass and Coulomb friction.
pub(super) struct Physics {
    /// Force on the slider, N.
    pub(super) force: &'static str,
    /// Whether it takes the place of Coulomb's friction.
    pub(super) replaces_friction: bool,
    /// The difference that it makes to the force where this is not `force`, N, with sign(0) = 0.
    pub(super) difference: Option<&'static str>,
    /// Abbreviations.
    pub(super) definitions: &'static [(&'static str, &'static str)],
    /// Further states: name, derivative, initial value.
    pub(super) states: &'static [(&'static str, &'static str, f64)],
    /// A strength to begin with.
    pub(super) strength: f64,
}

impl SliderEffect {
    /// The effects of the basic trial.
    pub const BASIC: [Self; 5] = [Self::Viscous, Self::Stribeck, Self::Tilt, Self::InputDelay, Self::QuadraticDrag];
    /// Further effects with a name in the library.
    pub const FURTHER: [Self; 6] = [
        Self::FrictionAsymmetry,
        Self::LinearStiffness,
        Self::CubicStiffness,
        Self::ActuatorLag,
        Self::PeriodicDisturbance,
        Self::Cogging,
    ];
    /// Effects that have no name in the library.
    pub const OUTSIDE: [Self; 6] = [
        Self::PositionDependentFriction,
        Self::CubicDrag,
        Self::ElasticMass,
        Self::BristleFriction,
        Self::WarmingFriction,
        Self::ForceLimit,
    ];

    /// Every effect.
    pub fn all() -> impl Iterator<Item = Self> {
        Self::BASIC.into_iter().chain(Self::FURTHER).chain(Self::OUTSIDE)
    }

    /// Its name, as on the command line of the example.
    pub fn name(self) -> &'static str {
        match self {
            Self::Viscous => "viscous",
            Self::Stribeck => "stribeck",
            Self::Tilt => "tilt",
            Self::InputDelay => "delay",
            Self::QuadraticDrag => "quadratic",
            Self::FrictionAsymmetry => "asymmetry",
            Self::LinearStiffness => "stiffness",
            Self::CubicStiffness => "cubic_stiffness",
            Self::ActuatorLag => "lag",
            Self::PeriodicDisturbance => "periodic",
            Self::PositionDependentFriction => "position_friction",
            Self::Cogging => "cogging",
            Self::CubicDrag => "cubic_drag",
            Self::ElasticMass => "elastic_mass",
            Self::BristleFriction => "bristles",
            Self::WarmingFriction => "warming",
            Self::ForceLimit => "limit",
        }
    }

    /// The effect of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::all().find(|effect| effect.name() == name)
    }

    /// The cause that a diagnosis should name; none for an effect outside the library.
    pub fn cause(self) -> Option<Cause> {
        match self {
            Self::Viscous => Some(Cause::ViscousFriction),
            Self::Stribeck => Some(Cause::StribeckFriction),
            Self::Tilt => Some(Cause::Tilt),
            Self::InputDelay => Some(Cause::InputDelay),
            Self::QuadraticDrag => Some(Cause::QuadraticDrag),
            Self::FrictionAsymmetry => Some(Cause::FrictionAsymmetry),
            Self::LinearStiffness => Some(Cause::LinearStiffness),
            Self::CubicStiffness => Some(Cause::CubicStiffness),
            Self::ActuatorLag => Some(Cause::ActuatorLag),
            Self::PeriodicDisturbance | Self::Cogging => Some(Cause::PeriodicDisturbance),
            Self::PositionDependentFriction
            | Self::CubicDrag
            | Self::ElasticMass
            | Self::BristleFriction
            | Self::WarmingFriction
            | Self::ForceLimit => None,
        }
    }

    /// A shape drawn at random: Stribeck velocity (m/s), frequency (Hz), wave number (1/m), hanging mass (share of the whole), time to
    /// warm up (s).
    pub(super) fn random_shape(self, random: &mut StdRng) -> f64 {
        match self {
            Self::Stribeck => 0.05 * 4f64.powf(random.random_range(0.0..1.0)),
            Self::PeriodicDisturbance => random.random_range(1.0..8.0),
            Self::PositionDependentFriction | Self::Cogging => std::f64::consts::TAU / random.random_range(0.05..0.3),
            Self::ElasticMass => random.random_range(0.2..0.4),
            Self::WarmingFriction => random.random_range(2.0..8.0),
            _ => 0.0,
        }
    }

    /// Whether its strength may have either sign.
    pub(super) fn either_sign(self) -> bool {
        matches!(self, Self::Tilt | Self::FrictionAsymmetry | Self::PositionDependentFriction | Self::Cogging)
    }

    /// Whether its strength is given instead of being made to fit a share of the drive.
    pub(super) fn given_strength(self, size: f64) -> Option<f64> {
        match self {
            // 8 ms for 10 %: at an rms frequency of 2 Hz.
            Self::InputDelay => Some(0.08 * size),
            // 0.2 mm/N for 10 %. The force grows with the fourth root only; smaller compliances would be very stiff equations.
            Self::BristleFriction => Some(2e-3 * size),
            _ => None,
        }
    }

    /// What it does.
    pub(super) fn physics(self) -> Physics {
        let plain = |force| Physics {
            force,
            replaces_friction: false,
            difference: None,
            definitions: &[],
            states: &[],
            strength: 0.3,
        };
        match self {
            Self::Viscous => plain("-{a}*v"),
            Self::Stribeck => plain("-{a}*exp(-(v/{b})^2)*sign(v)"),
            Self::Tilt => plain("{a}"),
            Self::InputDelay => Physics { difference: Some("u - command"), ..plain("0") },
            Self::QuadraticDrag => plain("-{a}*abs(v)*v"),
            Self::FrictionAsymmetry => plain("-{a}*sign(v)^2"),
            Self::LinearStiffness => plain("-{a}*x"),
            Self::CubicStiffness => plain("-{a}*x^3"),
            Self::ActuatorLag => {
                Physics { states: &[("late", "(u - late)/{a}", 0.0)], strength: 0.008, ..plain("late - u") }
            }
            Self::PeriodicDisturbance => Physics {
                states: &[("swing", "2*pi*{b}*other", 0.0), ("other", "-2*pi*{b}*swing", 1.0)],
                ..plain("{a}*swing")
            },
            Self::PositionDependentFriction => plain("-{a}*sin({b}*x)*sign(v)"),
            Self::Cogging => plain("{a}*sin({b}*x)"),
            Self::CubicDrag => plain("-{a}*v^3"),
            // The slider proper has the mass (1 − b) M: (1 − b) M v' = push + spring. While it rests it only feels the spring.
            Self::ElasticMass => Physics {
                difference: Some("spring + sign(v)^2*(inertia - spring)"),
                definitions: &[
                    ("spring", "stretch/{a} + sqrt({b}*M/{a})*(hanging - v)/10"),
                    ("inertia", "({b}*(u - F*sign(v)) + spring)/(1 - {b})"),
                ],
                states: &[("stretch", "hanging - v", 0.0), ("hanging", "-spring/({b}*M)", 0.0)],
                strength: 1e-3,
                ..plain("inertia")
            },
            Self::WarmingFriction => {
                Physics { states: &[("warmth", "(1 - warmth)/{b}", 0.0)], ..plain("-{a}*warmth*sign(v)") }
            }
            // The smaller the limit the larger the effect, and steeply so where only peaks are cut: the eighth power
            // lets the search for its strength converge.
            Self::ForceLimit => Physics {
                definitions: &[("limit", "{a}^(-1/8)")],
                strength: 1e-6,
                ..plain("(abs(u + limit) - abs(u - limit))/2 - u")
            },
            Self::BristleFriction => Physics {
                replaces_friction: true,
                difference: Some("F*sign(v) - bristles"),
                definitions: &[("slip", "v - abs(v)*bend/({a}*F)"), ("bristles", "bend/{a} + sqrt(M/{a})*slip")],
                states: &[("bend", "slip", 0.0)],
                ..plain("-bristles")
            },
        }
    }
}
