//! Logs of the object on the plate as a laboratory would record them.

use super::actuated_motion::ActuatedMotion;
use super::error::RecordingError;
use super::mismatch::PlateMismatch;
use super::random::Random;
use super::settings::RecordingSettings;
use crate::area::{AreaContact, AreaOutcome};
use crate::driven::Course;
use crate::experiment::Experiment;
use crate::log::PlateColumns;
use crate::{PlateError, PlateKinematics, PlateLog};

/// Greatest jump of displacement (m), tilt (rad) and their rates where an amplitude changes.
const SMOOTH: f64 = 1e-9;

/// A log of a simulated run.
#[derive(Debug, Clone, PartialEq)]
pub struct SyntheticLog {
    /// What was recorded.
    pub log: PlateLog,
    /// How the run ended.
    pub outcome: AreaOutcome,
}

impl SyntheticLog {
    /// A log of poses `x, y, phi` (m, rad) and commands at these times, with the noise of the settings added to the poses.
    pub fn measured(
        name: &str,
        rows: impl IntoIterator<Item = (f64, [f64; 3], PlateKinematics)>,
        outcome: AreaOutcome,
        settings: &RecordingSettings,
        seed: u64,
    ) -> Self {
        let mut random = Random::new(seed);
        let noise = [settings.position_noise, settings.position_noise, settings.angle_noise];
        let (mut t, mut commands, mut measured) = (Vec::new(), Vec::new(), [const { Vec::new() }; 3]);
        for (time, pose, command) in rows {
            t.push(time);
            commands.push(command);
            for i in 0..3 {
                measured[i].push(pose[i] + noise[i] * random.normal());
            }
        }
        let [x, y, phi] = measured;
        let plate = Some(PlateColumns::new(&commands, settings.derivatives));
        Self { log: PlateLog { name: name.to_owned(), t, x, y, phi, plate }, outcome }
    }
}

/// Runs an experiment on the object with contact over its footprint, in which an effect is hidden, and records it: the
/// measured pose with noise, the motion of the plate as it was commanded.
///
/// The object starts in the state `x, y, phi, vx, vy, w`. Where contact ends early, so does the log.
///
/// # Errors
/// [`RecordingError::Jump`] for an experiment whose plate would have to jump; [`RecordingError`] for settings without meaning.
///
/// ```
/// use bracketry_plate::experiment::Experiment;
/// use bracketry_plate::recording::{PlateMismatch, RecordingSettings, synthetic_log};
/// let start = [0.3, -0.03, 0.0, 0.0, 0.0, 0.0];
/// let settings = RecordingSettings::default();
/// let recorded = synthetic_log(&Experiment::translation_y(), start, 0.5, &PlateMismatch::None, &settings, 7).unwrap();
/// assert!(recorded.log.csv().starts_with("t,x,y,phi,X,theta\n0.000000,"));
/// assert_eq!(recorded.log.t.len(), 101);
/// ```
pub fn synthetic_log(
    experiment: &Experiment,
    start: [f64; 6],
    duration: f64,
    effect: &PlateMismatch,
    settings: &RecordingSettings,
    seed: u64,
) -> Result<SyntheticLog, RecordingError> {
    for (name, value) in [("rate", settings.rate), ("duration", duration), ("period", experiment.period)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(PlateError::BadNumber { name, value }.into());
        }
    }
    for (name, value) in [("position_noise", settings.position_noise), ("angle_noise", settings.angle_noise)] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(PlateError::NegativeNumber { name, value }.into());
        }
    }
    let mut contact = effect.contact(settings)?;
    contact.set_state(start)?;
    let mut plate = ActuatedMotion::new(experiment.motion(0.0)?, effect, settings.area.gravity);
    let (mut course, mut outcome) = contact.record(&mut plate, 0.0)?;
    let samples = (duration * settings.rate + 1e-9).floor() as usize;
    let mut times = Vec::with_capacity(samples + 1);
    let mut commands = Vec::with_capacity(samples + 1);
    let mut period = 0u32;
    while outcome.is_finished() && contact.time() < duration {
        let t = contact.time();
        update_amplitude(experiment, &contact, &mut plate, period == 0)?;
        period += 1;
        let last = f64::from(period) * experiment.period >= duration;
        let end = if last { duration } else { f64::from(period) * experiment.period };
        let (piece, ended) = contact.record(&mut plate, end)?;
        outcome = ended;
        let reached = contact.time();
        while times.len() <= samples {
            let at = times.len() as f64 / settings.rate;
            if at < t || at > reached || (at == reached && !last) {
                break;
            }
            times.push(at);
            commands.push(plate.command(at));
        }
        course.join(&piece);
    }
    let delay = if let PlateMismatch::SensorDelay(time) = *effect { time } else { 0.0 };
    let point = if let PlateMismatch::CenterOfMass(at) = *effect { at } else { [0.0; 2] };
    let seen = times.iter().map(|t| {
        let state = course.state_at((t - delay).max(0.0));
        let (sin, cos) = state[2].sin_cos();
        [state[0] + cos * point[0] - sin * point[1], state[1] + sin * point[0] + cos * point[1], state[2]]
    });
    let poses: Vec<[f64; 3]> = seen.collect();
    let rows = times.into_iter().zip(poses).zip(commands).map(|((t, pose), command)| (t, pose, command));
    Ok(SyntheticLog::measured(&experiment.name, rows, outcome, settings, seed))
}

/// Sets the amplitude of the period that starts now.
fn update_amplitude(
    experiment: &Experiment,
    contact: &AreaContact,
    plate: &mut ActuatedMotion,
    first: bool,
) -> Result<(), RecordingError> {
    let t = contact.time();
    let coordinate = contact.state()[experiment.index()];
    let before = plate.command(t);
    plate.set_amplitude(t, experiment.amplitude(coordinate - experiment.target));
    let after = plate.command(t);
    let jumps = [
        after.displacement - before.displacement,
        after.velocity - before.velocity,
        after.tilt - before.tilt,
        after.tilt_rate - before.tilt_rate,
    ];
    if !first && jumps.iter().any(|jump| jump.abs() > SMOOTH) {
        return Err(RecordingError::Jump { t });
    }
    Ok(())
}
