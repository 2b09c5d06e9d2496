//! Which experiment tells two causes apart.

use std::f64::consts::TAU;

use bracketry_system::System;

use super::names::TIME_INPUT;
use crate::effect::{Cause, Change, Effect};

/// A sentence that names an experiment after which two causes would not be confused.
///
/// Delays, lags and shapes are quoted at the nominal values of the coefficients: pass effects with the fitted ones there,
/// as far as they are known. The order of the two does not matter.
pub fn separating_experiment(a: &Effect, b: &Effect, system: &System) -> String {
    let (a, b) = if a.cause <= b.cause { (a, b) } else { (b, a) };
    if a.cause == b.cause {
        return same_cause(a, b, system);
    }
    let special = special(a, b, system).or_else(|| by_family(a, b, system));
    special.unwrap_or_else(|| {
        format!(
            "{}, and {}; the effect of {} changes only in the first experiment, that of {} only in the second",
            isolating(a, system),
            isolating(b, system),
            a.cause.words(),
            b.cause.words()
        )
    })
}

/// What families of causes look like in data.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Family {
    /// A force that depends on the own velocity.
    Rate,
    /// A force that is always there.
    Constant,
    /// A force that depends on the position.
    Position,
    /// Something between a signal and what it stands for.
    Timing,
    /// A scale or an offset of a signal.
    Scale,
    /// What one coordinate does to another.
    Coupling,
    /// Friction of a contact that slides in more than one direction.
    Contact,
    Other,
}

fn family(cause: Cause) -> Family {
    match cause {
        Cause::ViscousFriction
        | Cause::CoulombFriction
        | Cause::StribeckFriction
        | Cause::QuadraticDrag
        | Cause::FrictionAsymmetry => Family::Rate,
        Cause::ConstantBias | Cause::Tilt => Family::Constant,
        Cause::LinearStiffness | Cause::CubicStiffness => Family::Position,
        Cause::InputDelay | Cause::ActuatorLag | Cause::SensorDelay | Cause::SensorLag => Family::Timing,
        Cause::InputGain | Cause::ParameterError | Cause::SensorBias => Family::Scale,
        Cause::InertialCoupling | Cause::JointCoupling => Family::Coupling,
        Cause::FrictionCoupling
        | Cause::AnisotropicFriction
        | Cause::PressureRadius
        | Cause::YawFriction
        | Cause::ComOffset => Family::Contact,
        Cause::PeriodicDisturbance
        | Cause::ParameterJump
        | Cause::ElasticJoint
        | Cause::HiddenVibration
        | Cause::Hysteresis
        | Cause::LiftOff
        | Cause::Backlash
        | Cause::DeadZone
        | Cause::Saturation
        | Cause::SensorDrift
        | Cause::Leak
        | Cause::QuadraticLoss
        | Cause::WrongSign
        | Cause::WrongUnit
        | Cause::SwappedColumns
        | Cause::WrongColumn
        | Cause::UnknownTerm => Family::Other,
    }
}

/// The position whose rate the effect acts on, or what it acts on itself.
fn position(e: &Effect, system: &System) -> String {
    let rate = system.state_index(&e.equation);
    let state = rate.and_then(|r| {
        let rate = system.states[r];
        (0..system.states.len()).find(|&q| q != r && system.pool.symbols_of(&[system.dynamics[q]]) == [rate])
    });
    state.map_or_else(|| e.equation.clone(), |q| system.symbol_name(system.states[q]).to_owned())
}

/// The longest time constant among the coefficients, if one is known.
fn time_constant(effects: [&Effect; 2]) -> Option<f64> {
    let known = effects
        .into_iter()
        .filter(|e| matches!(e.change, Change::Path { .. }))
        .flat_map(|e| &e.coefficients)
        .map(|c| c.nominal)
        .filter(|t| *t > 0.0 && t.is_finite());
    known.reduce(f64::max)
}

/// A number with three digits.
fn short(x: f64) -> String {
    let digits = (2 - x.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The frequency above which a delay and a lag differ.
fn corner(effects: [&Effect; 2]) -> String {
    time_constant(effects).map_or_else(
        || "frequencies above 1/(2 pi tau)".to_owned(),
        |t| format!("frequencies above 1/(2 pi tau) = {} Hz", short(1.0 / (TAU * t))),
    )
}

fn same_cause(a: &Effect, b: &Effect, system: &System) -> String {
    if a.equation == b.equation {
        return match family(a.cause) {
            Family::Rate | Family::Contact => format!(
                "drive {} at constant speeds close together and down to the slowest that can be held: the two forms \
                 differ in how the force changes with speed there",
                a.equation
            ),
            Family::Timing => format!("excite {} more strongly, and each signal of it at its own time", a.equation),
            _ => format!(
                "repeat the experiment with {} over a wider range, at other speeds: the two forms grow differently \
                 with it",
                position(a, system)
            ),
        };
    }
    format!("excite {} and {} one at a time, with the other at rest", a.equation, b.equation)
}

/// Experiments for pairs that need one of their own.
fn special(a: &Effect, b: &Effect, system: &System) -> Option<String> {
    use Cause::{
        ActuatorLag, AnisotropicFriction, Backlash, ComOffset, ConstantBias, CoulombFriction, CubicStiffness,
        FrictionAsymmetry, FrictionCoupling, InertialCoupling, InputDelay, InputGain, JointCoupling, LinearStiffness,
        ParameterError, PeriodicDisturbance, PressureRadius, SensorBias, SensorDelay, SensorLag, Tilt, ViscousFriction,
        YawFriction,
    };
    let q = position(a, system);
    Some(match (a.cause, b.cause) {
        (ViscousFriction, ActuatorLag | InputDelay | SensorDelay | SensorLag) => format!(
            "add fast content to the input, at {}: the phase of a delay or lag grows with frequency, that of viscous \
             friction falls",
            corner([a, b])
        ),
        (ConstantBias, Tilt) => {
            "turn the device by 180 degrees about the vertical and repeat: the force of a slope reverses, that of a \
             bias turns with the device"
                .to_owned()
        }
        (FrictionAsymmetry, ConstantBias | Tilt) => format!(
            "hold several constant speeds of {} in both directions, from slow to fast: a constant force is the same \
             at all of them, direction-dependent friction grows with speed; turning the device by 180 degrees \
             separates its Coulomb part from a slope",
            a.equation
        ),
        (CoulombFriction | ViscousFriction, Backlash) => format!(
            "measure {q} on both sides of the drive, and reverse slowly with small strokes: with play, the driven \
             side does not move over the same distance for any force"
        ),
        (LinearStiffness, CubicStiffness) => format!(
            "use strokes of {q} twice and half as long: the cubic force \
        changes eightfold"
        ),
        (LinearStiffness | CubicStiffness, PeriodicDisturbance) => {
            format!(
                "travel slowly over several periods of {q}, as far as the device allows: the force of a spring \
                     is not periodic"
            )
        }
        (LinearStiffness | CubicStiffness | ConstantBias | Tilt, SensorBias) => format!(
            "release the device at several positions and measure where it rests, with {q} read off by a second instrument"
        ),
        (SensorDelay, SensorLag) => format!(
            "add content to the input at {}: a filter also makes the readings smaller there, a delay does not",
            corner([a, b])
        ),
        (InputDelay, ActuatorLag) => {
            format!(
                "add content to the input at {}: a lag also makes the response smaller there, a delay does not",
                corner([a, b])
            )
        }
        (InputDelay | ActuatorLag, SensorDelay | SensorLag) => {
            "record the input where it acts with the same instrument as the motion (or one event, such as a knock, \
             with all instruments): a delay of the sensors shifts that record too"
                .to_owned()
        }
        (InputGain, ParameterError) => {
            "add a known mass, or hang a known weight on the drive: a wrong gain changes the response to the input, \
             not to the weight"
                .to_owned()
        }
        (FrictionCoupling, AnisotropicFriction) => {
            "slide in straight lines along each axis and at 45 degrees between them: coupled friction has the same \
             level in all directions"
                .to_owned()
        }
        (PressureRadius, AnisotropicFriction | FrictionCoupling) => {
            "spin the body without sliding, then slide it without spin along each axis: the location of the pressure \
             affects only the first"
                .to_owned()
        }
        (YawFriction | ViscousFriction, PressureRadius) => {
            "let the body spin out without sliding, from a fast and from a slow spin: friction of pressure at a \
             radius is the same at all spin rates"
                .to_owned()
        }
        (YawFriction, FrictionCoupling) => {
            "spin the body without sliding, then slide it without spin along a slanted line: spin friction acts only \
             in the first, coupling of the axes only in the second"
                .to_owned()
        }
        (AnisotropicFriction | PressureRadius | YawFriction | FrictionCoupling, ComOffset) => {
            "repeat with the body turned by 90 and 180 degrees: the effect of its center of mass turns with the \
             body"
                .to_owned()
        }
        (InertialCoupling, YawFriction | FrictionCoupling)
        | (AnisotropicFriction | PressureRadius, InertialCoupling) => {
            "repeat the same motion at half the frequency: inertial forces fall to a quarter, dry friction \
             stays"
                .to_owned()
        }
        (InertialCoupling, JointCoupling) => {
            format!(
                "move the other joint at constant speed, then accelerate it with {q} held at several positions: inertial \
            forces need acceleration or high speed, friction does not"
            )
        }
        _ => return None,
    })
}

/// Experiments for pairs of families.
fn by_family(a: &Effect, b: &Effect, system: &System) -> Option<String> {
    let v = &a.equation;
    let (fa, fb) = (family(a.cause), family(b.cause));
    let either = |x: Family, y: Family| (fa, fb) == (x, y) || (fa, fb) == (y, x);
    let q = position(if fa == Family::Position { a } else { b }, system);
    if either(Family::Rate, Family::Rate) {
        return Some(format!(
            "hold constant speeds of {v} over a wider range, in both directions, the fastest at least twice and the \
             slowest at most a tenth of the present ones: the required force shows the law (flat: Coulomb, straight: \
             viscous, parabola: drag, a peak or dip at the slow end: Stribeck or concave, not odd: asymmetry)"
        ));
    }
    if either(Family::Rate, Family::Constant) {
        return Some(format!(
            "move {v} at the same speed in both directions: friction changes its sign, a constant force does not"
        ));
    }
    if either(Family::Rate, Family::Position) {
        return Some(format!(
            "pass the same positions {q} at different speeds, and hold it still away from the middle: an elastic force \
             depends on the position only"
        ));
    }
    if either(Family::Position, Family::Constant) {
        return Some(format!(
            "operate around two positions {q} far apart: an elastic force differs between them, a constant one does not"
        ));
    }
    if either(Family::Timing, Family::Timing) {
        return Some(format!(
            "add content to the inputs at {}, one input at a time, and record the acting signals with the same \
             instrument",
            corner([a, b])
        ));
    }
    if fa == Family::Timing || fb == Family::Timing {
        return Some(format!(
            "add content to the input at {}: a delay is the same at all frequencies; a force also acts at low \
             frequencies",
            corner([a, b])
        ));
    }
    if either(Family::Coupling, Family::Rate) {
        return Some(
            "move one coordinate with the others held, then the others with this one held: a coupling \
                     appears only in the second run"
                .to_owned(),
        );
    }
    if fa == Family::Scale || fb == Family::Scale {
        return Some(format!(
            "repeat the experiment with half and with twice the amplitude of the input, and once without input ({} \
             grows differently from {})",
            a.cause.words(),
            b.cause.words()
        ));
    }
    None
}

/// What tells columns that are read wrongly.
pub(crate) const OF_COLUMNS: &str = "record one motion of known direction and size, and compare each column with it";

/// What shows a cause by itself.
fn isolating(e: &Effect, system: &System) -> String {
    let (v, q) = (&e.equation, position(e, system));
    match e.cause {
        Cause::ViscousFriction
        | Cause::CoulombFriction
        | Cause::StribeckFriction
        | Cause::QuadraticDrag
        | Cause::FrictionAsymmetry => format!("hold constant speeds of {v} in both directions"),
        Cause::ConstantBias | Cause::Tilt => format!("compare both directions of {v} at the same speed"),
        Cause::LinearStiffness | Cause::CubicStiffness => format!("hold {q} still at several positions"),
        Cause::InputGain | Cause::ParameterError => "scale the input by two".to_owned(),
        Cause::InputDelay | Cause::ActuatorLag | Cause::SensorDelay | Cause::SensorLag => {
            "add fast content to the input".to_owned()
        }
        Cause::Leak | Cause::QuadraticLoss => format!("let {v} fall without input, from a high and from a low value"),
        Cause::SensorBias => format!("read {v} at rest against a second instrument"),
        Cause::ElasticJoint | Cause::HiddenVibration => {
            format!("knock on what moves with {v} while the input rests, and record how it rings")
        }
        Cause::Hysteresis => format!("move {q} slowly to and fro, with large and with small strokes"),
        Cause::ParameterJump => "repeat the same run, long before and long after the time of the change".to_owned(),
        Cause::SensorDrift => format!("read {v} at rest over a long time"),
        Cause::DeadZone => format!("apply small values of {v}, growing slowly from 0"),
        Cause::Saturation => format!("repeat with {v} at half its size"),
        Cause::PeriodicDisturbance if e.coefficients.iter().any(|c| c.period_of.as_deref() == Some(TIME_INPUT)) => {
            "record once with the input at rest".to_owned()
        }
        Cause::PeriodicDisturbance => format!("move {q} slowly at two constant speeds"),
        Cause::InertialCoupling => "repeat the motion at half the frequency".to_owned(),
        Cause::JointCoupling => format!("move the other joints with {v} held"),
        Cause::YawFriction | Cause::PressureRadius => "spin the body without sliding".to_owned(),
        Cause::FrictionCoupling | Cause::AnisotropicFriction => {
            "slide in straight lines in several directions".to_owned()
        }
        Cause::ComOffset => "turn the body by 180 degrees and repeat".to_owned(),
        Cause::LiftOff => "keep all accelerations small enough that the load stays positive".to_owned(),
        Cause::Backlash => format!("reverse {v} slowly with small strokes"),
        Cause::WrongSign | Cause::WrongUnit | Cause::SwappedColumns | Cause::WrongColumn => OF_COLUMNS.to_owned(),
        Cause::UnknownTerm => format!("repeat with {q} over a wider range and at other speeds"),
    }
}
