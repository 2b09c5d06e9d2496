//! Mismatches between the plant and its model that a log may hide.

use super::random::{Random, seed_of};
use super::settings::RecordingSettings;
use crate::area::AreaContact;
use crate::control::AreaLoopPlant;
use crate::object::Bearing;
use crate::{Friction, Object, PlateError, PlateKinematics};
use serde::{Deserialize, Serialize};

/// What is otherwise in the real plant than its user believes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlateMismatch {
    /// Nothing.
    None,
    /// The plate's tilt is greater than its command by this angle in rad.
    TiltAboutX(f64),
    /// The axis of the plate is inclined: gravity pulls along +x with `g sin` of this angle in rad.
    TiltAboutY(f64),
    /// Friction is this many times as great as believed.
    Friction(f64),
    /// Displacement and tilt follow their commands with a first-order lag of this time in s.
    ActuatorLag(f64),
    /// The point that the camera tracks lies here, seen from the center of mass in the object's own axes, in m.
    CenterOfMass([f64; 2]),
    /// The camera tells where the object was this long ago, in s.
    SensorDelay(f64),
    /// Friction across the axis of the plate over that along it, with the believed geometric mean.
    AnisotropicFriction(f64),
    /// The radius of gyration of the pressure over that of the footprint: below 1 the object presses on the inner part of its
    /// footprint, above 1 on a ring within it. Exact for a disk.
    PressureRadius(f64),
}

impl PlateMismatch {
    /// Names of the kinds, as [`PlateMismatch::draw_kind`] takes them.
    pub const KINDS: [&'static str; 9] = [
        "none",
        "tilt_about_x",
        "tilt_about_y",
        "friction",
        "actuator_lag",
        "centre_of_mass",
        "sensor_delay",
        "anisotropic_friction",
        "pressure_radius",
    ];

    /// A mismatch of a random kind, nothing being one of them, of random direction or sign: 0.5° of tilt, 10 % of friction,
    /// 20 ms of lag, 5 mm of the center of mass, 15 ms of delay, 20 % between the axes, 15 % of the
    /// radius of the pressure.
    pub fn draw(seed: u64) -> Self {
        let kind = Random::new(seed).below(Self::KINDS.len());
        Self::of_kind(kind, seed)
    }

    /// The same of a kind; absent if there is none of that name.
    pub fn draw_kind(kind: &str, seed: u64) -> Option<Self> {
        Some(Self::of_kind(Self::KINDS.iter().position(|k| *k == kind)?, seed))
    }

    fn of_kind(kind: usize, seed: u64) -> Self {
        let mut random = Random::new(seed_of(seed, 0));
        let sign = if random.happens(0.5) { 1.0 } else { -1.0 };
        match kind {
            0 => Self::None,
            1 => Self::TiltAboutX(sign * 0.5f64.to_radians()),
            2 => Self::TiltAboutY(sign * 0.5f64.to_radians()),
            3 => Self::Friction(1.0 + sign * 0.1),
            4 => Self::ActuatorLag(0.020),
            5 => {
                let (sin, cos) = random.between([0.0, std::f64::consts::TAU]).sin_cos();
                Self::CenterOfMass([0.005 * cos, 0.005 * sin])
            }
            6 => Self::SensorDelay(0.015),
            7 => Self::AnisotropicFriction(1.2f64.powf(sign)),
            _ => Self::PressureRadius(1.0 - sign * 0.15),
        }
    }

    /// The object as it truly is, with contact over its footprint.
    ///
    /// # Errors
    /// [`PlateError`] for settings without meaning.
    pub fn contact(&self, settings: &RecordingSettings) -> Result<AreaContact, PlateError> {
        let mu = settings.mu;
        let friction = match *self {
            Self::Friction(factor) => Friction::Coulomb { mu: factor * mu },
            Self::AnisotropicFriction(ratio) => {
                Friction::Anisotropic { mu_along: mu / ratio.sqrt(), mu_across: mu * ratio.sqrt() }
            }
            _ => Friction::Coulomb { mu },
        };
        let mut area = settings.area.clone();
        if let Self::TiltAboutY(angle) = *self {
            area.gravity *= angle.cos();
        }
        let bearing = match *self {
            Self::PressureRadius(ratio) if ratio > 1.0 => Bearing::Ring(ratio / 2f64.sqrt()),
            Self::PressureRadius(ratio) => Bearing::Scaled(ratio),
            _ => settings.object.bearing.clone(),
        };
        AreaContact::new(&Object { bearing, ..settings.object.clone() }, &friction, &area)
    }

    /// The object as it truly is as the plant of a control loop.
    ///
    /// # Errors
    /// [`PlateError`] for settings without meaning.
    pub fn loop_plant(&self, settings: &RecordingSettings) -> Result<AreaLoopPlant, PlateError> {
        let (mismatch, gravity) = (*self, settings.area.gravity);
        Ok(AreaLoopPlant::new(self.contact(settings)?)
            .with_actual_motion(move |plate| mismatch.inclined(plate, gravity)))
    }

    /// How a plate that moves like this appears to [`PlateMismatch::contact`]: its tilt with what is added to it; what an
    /// inclined axis lets gravity (m/s²) do along x, as an acceleration of the plate in the opposite direction.
    #[must_use]
    pub fn inclined(&self, mut plate: PlateKinematics, gravity: f64) -> PlateKinematics {
        match *self {
            Self::TiltAboutX(angle) => plate.tilt += angle,
            Self::TiltAboutY(angle) => plate.acceleration -= gravity * angle.sin(),
            _ => {}
        }
        plate
    }

    /// Its kind, one of [`PlateMismatch::KINDS`].
    pub fn kind(&self) -> &'static str {
        let place = match self {
            Self::None => 0,
            Self::TiltAboutX(_) => 1,
            Self::TiltAboutY(_) => 2,
            Self::Friction(_) => 3,
            Self::ActuatorLag(_) => 4,
            Self::CenterOfMass(_) => 5,
            Self::SensorDelay(_) => 6,
            Self::AnisotropicFriction(_) => 7,
            Self::PressureRadius(_) => 8,
        };
        Self::KINDS[place]
    }
}
