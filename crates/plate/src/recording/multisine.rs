//! A plate motion of many frequencies.

use super::error::RecordingError;
use super::mismatch::PlateMismatch;
use super::random::{Random, seed_of};
use super::settings::RecordingSettings;
use crate::experiment::{AmplitudeStep, Coordinate, Experiment};
use crate::motion::ExpressionMotion;
use crate::{PlateError, PlateMotion};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Sines in each of displacement and tilt.
const SINES: usize = 4;
/// Least and greatest frequency in Hz.
const FREQUENCIES: [f64; 2] = [1.2, 3.2];
/// Greatest displacement in m.
const STROKE: f64 = 0.095;
/// Greatest tilt in degrees.
const TILT: f64 = 18.0;
/// How far the object may move away from where it starts, in m.
const REACH: f64 = 0.12;
/// Motions that are tried with the greatest displacement and tilt; each later one is smaller by a constant ratio.
const FULL_TRIES: u64 = 150;
/// Motions that are tried in all, and the part of the greatest motion that the last of them has.
const TRIES: u64 = 250;
const SMALLEST: f64 = 0.4;
/// Length of the pieces in which a motion is tried, in s: whole steps of the simulation.
const PIECE: f64 = 0.2;

/// A multisine in displacement and tilt, of four frequencies each between 1.2 and 3.2 Hz with equal amplitudes of
/// acceleration, random phases, faded in over half a second; at most 95 mm and 18°.
///
/// Phases are drawn until the assumed object stays within 0.12 m of where it starts, on the plate and
/// without tipping; where the greatest motions let it slip away every time, smaller ones are tried.
///
/// # Errors
/// [`RecordingError::NoMultisine`] if no such motion is found; [`RecordingError`] for settings without meaning.
pub fn multisine(
    start: [f64; 6],
    duration: f64,
    settings: &RecordingSettings,
    seed: u64,
) -> Result<Experiment, RecordingError> {
    if !(duration.is_finite() && duration > 0.0) {
        return Err(PlateError::BadNumber { name: "duration", value: duration }.into());
    }
    let area = settings.area.clone().with_step(4e-3).with_points(16);
    let coarse = RecordingSettings { area, ..settings.clone() };
    for index in 0..TRIES {
        let mut random = Random::new(seed_of(seed, index));
        let smaller = index.saturating_sub(FULL_TRIES) as f64 / (TRIES - FULL_TRIES - 1) as f64;
        let part = SMALLEST.powf(smaller);
        let displacement = sines(&mut random, part * STROKE, duration)?;
        let tilt = sines(&mut random, part * TILT.to_radians(), duration)?;
        let experiment = Experiment {
            name: "multisine".into(),
            coordinate: Coordinate::X,
            start: start[0],
            target: start[0],
            period: duration,
            displacement,
            tilt,
            law: None,
            step: AmplitudeStep::Smooth,
        };
        if stays(&experiment, start, duration, &coarse)? {
            return Ok(experiment);
        }
    }
    Err(RecordingError::NoMultisine { tries: TRIES })
}

/// Whether the object stays within reach of where it starts, on the plate and without tipping; simulated piece by piece, as most
/// motions let it slip away early.
fn stays(
    experiment: &Experiment,
    start: [f64; 6],
    duration: f64,
    settings: &RecordingSettings,
) -> Result<bool, RecordingError> {
    let mut contact = PlateMismatch::None.contact(settings)?;
    contact.set_state(start)?;
    let mut plate = experiment.motion(0.0)?;
    let pieces = (duration / PIECE).ceil().max(1.0);
    for piece in 1..=pieces as u32 {
        let mut away: f64 = 0.0;
        let end = duration * f64::from(piece) / pieces;
        let outcome = contact.advance_with(&mut plate, end, |sample| {
            let [x, y, ..] = sample.state;
            away = away.max((x - start[0]).abs()).max((y - start[1]).abs());
        })?;
        if !outcome.is_finished() || away > REACH {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The sum of sines as an expression of `t`, scaled to its greatest value.
fn sines(random: &mut Random, greatest: f64, duration: f64) -> Result<String, RecordingError> {
    let step = (FREQUENCIES[1] - FREQUENCIES[0]) / SINES as f64;
    let mut sum = String::new();
    for k in 0..SINES {
        let low = FREQUENCIES[0] + k as f64 * step;
        let omega = TAU * random.between([low, low + step]);
        let phase = random.between([0.0, TAU]);
        let _ = write!(sum, "{}{}*sin({omega}*t + {phase})", if k == 0 { "" } else { " + " }, 1.0 / (omega * omega));
    }
    let faded = |factor: f64| format!("{factor}*({sum})*(1 - exp(-8*(t - t0)^2))");
    let mut motion = ExpressionMotion::new(&faded(1.0), "0", &[("t0", 0.0)])?;
    let samples = (duration * 500.0).ceil() as u32;
    let peak = (0..=samples).map(|i| motion.at(f64::from(i) / 500.0).displacement.abs()).fold(0.0, f64::max);
    Ok(faded(greatest / peak))
}
