//! What names are worth before any data: the order in which causes are preferred where the data leave it open.

use crate::{Cause, Change, Effect, Path};

/// Twice the logarithm of the odds against a cause, compared with the most common ones.
///
/// `measured` is the number of measured columns. Far below what data can say: it decides between explanations that fit equally well. Friction and constant forces come
/// first, then effects in signal paths (one signal before several, inputs before measured columns), then forces that
/// need a special cause; terms from the dictionary, of which there are many and which have no name, come last.
pub(crate) fn surprise(effect: &Effect, measured: usize) -> f64 {
    let name = match effect.cause {
        Cause::ViscousFriction | Cause::CoulombFriction | Cause::Tilt | Cause::ParameterError => 0.0,
        Cause::StribeckFriction
        | Cause::QuadraticDrag
        | Cause::FrictionAsymmetry
        | Cause::InputGain
        | Cause::ConstantBias
        | Cause::LinearStiffness
        | Cause::YawFriction
        | Cause::InputDelay
        | Cause::FrictionCoupling
        | Cause::PressureRadius
        | Cause::InertialCoupling
        | Cause::JointCoupling
        | Cause::ComOffset => 0.5,
        Cause::ActuatorLag | Cause::AnisotropicFriction => 0.75,
        Cause::SensorDelay
        | Cause::CubicStiffness
        | Cause::SensorBias
        | Cause::DeadZone
        | Cause::Saturation
        | Cause::Leak
        | Cause::QuadraticLoss => 1.0,
        Cause::SensorLag => 1.25,
        Cause::SensorDrift
        | Cause::PeriodicDisturbance
        | Cause::ParameterJump
        | Cause::ElasticJoint
        | Cause::HiddenVibration
        | Cause::Hysteresis
        | Cause::Backlash
        | Cause::LiftOff
        | Cause::WrongSign
        | Cause::WrongUnit
        | Cause::SwappedColumns
        | Cause::WrongColumn => 1.5,
        Cause::UnknownTerm => 8.0,
    };
    // All measured columns late by the same time is one chain of sensors, as a camera; several inputs is a coincidence.
    let channels = match &effect.change {
        Change::Path { path: Path::SensorDelay, signals } if signals.len() == measured => 1,
        Change::Path { signals, .. } => signals.len(),
        _ => 1,
    };
    name + 0.75 * channels.saturating_sub(1) as f64
}
