//! Logs of the object on the plate as a laboratory would record them, with an effect hidden in the plant.

mod hidden;
mod imposed;
mod multisine;

pub use hidden::HiddenEffect;
pub use multisine::multisine;

use crate::monte_carlo::Random;
use crate::{AreaContact, AreaOutcome, AreaSettings, Course, Experiment, Object, PlateError, PlateKinematics, STATES};
use imposed::Imposed;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Greatest jump of displacement (m), tilt (rad) and their rates where an amplitude changes.
const SMOOTH: f64 = 1e-9;

/// What is believed of the plant, and how it is recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct LogSettings {
    /// The object.
    pub object: Object,
    /// Friction coefficient.
    pub mu: f64,
    /// Samples per second.
    pub rate: f64,
    /// Standard deviation of the noise of the measured position, in m.
    pub position_noise: f64,
    /// Standard deviation of the noise of the measured yaw, in rad.
    pub angle_noise: f64,
    /// Whether the log has columns `der(X,2)`, `der(theta,1)`, `der(theta,2)`.
    pub derivatives: bool,
    /// How the plant is simulated; gravity and terms are part of the truth.
    pub area: AreaSettings,
}

impl Default for LogSettings {
    /// The reference disk, friction 0.3, 200 Hz with noise of 0.5 mm and 0.3°, no columns of derivatives.
    fn default() -> Self {
        Self {
            object: Object::REFERENCE,
            mu: 0.3,
            rate: 200.0,
            position_noise: 0.5e-3,
            angle_noise: 0.3f64.to_radians(),
            derivatives: false,
            area: AreaSettings::default(),
        }
    }
}

/// A recorded run.
#[derive(Debug, Clone, PartialEq)]
pub struct PlateLog {
    /// The experiment.
    pub name: String,
    /// Times in s.
    pub times: Vec<f64>,
    /// Columns by name: measured `x, y` (m), `phi` (rad), commanded `X` (m), `theta` (rad) and derivatives, if wanted.
    pub columns: Vec<(String, Vec<f64>)>,
    /// How the run ended.
    pub outcome: AreaOutcome,
}

impl PlateLog {
    /// A column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(n, _)| n == name).map(|(_, values)| values.as_slice())
    }

    /// The columns, times not among them.
    pub fn by_name(&self) -> BTreeMap<String, Vec<f64>> {
        self.columns.iter().cloned().collect()
    }

    /// A log of poses `x, y, phi` (m, rad) and commands at these times, with the noise of the settings added to the poses.
    /// Poses or commands beyond the shortest of the three are left out.
    pub fn measured(
        name: &str,
        times: Vec<f64>,
        poses: &[[f64; 3]],
        commands: &[PlateKinematics],
        outcome: AreaOutcome,
        settings: &LogSettings,
        seed: u64,
    ) -> Self {
        let rows = times.len().min(poses.len()).min(commands.len());
        let mut times = times;
        times.truncate(rows);
        let (poses, commands) = (&poses[..rows], &commands[..rows]);
        let mut random = Random::new(seed);
        let noise = [settings.position_noise, settings.position_noise, settings.angle_noise];
        let mut measured = [const { Vec::new() }; 3];
        for pose in poses {
            for i in 0..3 {
                measured[i].push(pose[i] + noise[i] * random.normal());
            }
        }
        let mut columns: Vec<(String, Vec<f64>)> = STATES.iter().map(|name| (*name).to_owned()).zip(measured).collect();
        columns.push(("X".into(), commands.iter().map(|k| k.displacement).collect()));
        columns.push(("theta".into(), commands.iter().map(|k| k.tilt).collect()));
        if settings.derivatives {
            columns.push(("der(X,2)".into(), commands.iter().map(|k| k.acceleration).collect()));
            columns.push(("der(theta,1)".into(), commands.iter().map(|k| k.tilt_rate).collect()));
            columns.push(("der(theta,2)".into(), commands.iter().map(|k| k.tilt_acceleration).collect()));
        }
        Self { name: name.to_owned(), times, columns, outcome }
    }

    /// The log as text: a header, then a row per time.
    pub fn csv(&self) -> String {
        // Names with a comma are quoted.
        let quoted = |name: &str| if name.contains(',') { format!("\"{name}\"") } else { name.to_owned() };
        let mut text = String::from("t");
        for (name, _) in &self.columns {
            let _ = write!(text, ",{}", quoted(name));
        }
        for (row, t) in self.times.iter().enumerate() {
            let _ = write!(text, "\n{t:.6}");
            for (_, values) in &self.columns {
                let _ = write!(text, ",{:.9}", values[row]);
            }
        }
        text.push('\n');
        text
    }
}

/// Runs an experiment on the object with contact over its footprint, in which an effect is hidden, and records it: the
/// measured pose with noise, the motion of the plate as it was commanded.
///
/// The object starts in the state `x, y, phi, vx, vy, w`. Where contact ends early, so does the log.
///
/// # Errors
/// [`PlateError::Jump`] for an experiment whose plate would have to jump; [`PlateError`] for settings without meaning.
///
/// ```
/// use bracketry_plate::{Experiment, HiddenEffect, LogSettings, plate_log};
/// let start = [0.3, -0.03, 0.0, 0.0, 0.0, 0.0];
/// let settings = LogSettings::default();
/// let log = plate_log(&Experiment::translation_y(), start, 0.5, &HiddenEffect::None, &settings, 7).unwrap();
/// assert!(log.csv().starts_with("t,x,y,phi,X,theta\n0.000000,"));
/// assert_eq!(log.times.len(), 101);
/// ```
pub fn plate_log(
    experiment: &Experiment,
    start: [f64; 6],
    duration: f64,
    effect: &HiddenEffect,
    settings: &LogSettings,
    seed: u64,
) -> Result<PlateLog, PlateError> {
    for (name, value) in [("rate", settings.rate), ("duration", duration), ("period", experiment.period)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(PlateError::BadNumber { name, value });
        }
    }
    for (name, value) in [("position_noise", settings.position_noise), ("angle_noise", settings.angle_noise)] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(PlateError::NegativeNumber { name, value });
        }
    }
    let mut contact = effect.contact(settings)?;
    contact.set_state(start)?;
    let mut plate = Imposed::new(experiment.motion(0.0)?, effect, settings.area.gravity);
    let (mut course, mut outcome) = contact.record(&mut plate, 0.0)?;
    let samples = (duration * settings.rate + 1e-9).floor() as usize;
    let mut times = Vec::with_capacity(samples + 1);
    let mut commands = Vec::with_capacity(samples + 1);
    let mut period = 0u32;
    while outcome.is_finished() && contact.time() < duration {
        let t = contact.time();
        renew(experiment, &contact, &mut plate, period == 0)?;
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
    let delay = if let HiddenEffect::SensorDelay(time) = *effect { time } else { 0.0 };
    let point = if let HiddenEffect::CentreOfMass(at) = *effect { at } else { [0.0; 2] };
    let seen = times.iter().map(|t| {
        let state = course.state_at((t - delay).max(0.0));
        let (sin, cos) = state[2].sin_cos();
        [state[0] + cos * point[0] - sin * point[1], state[1] + sin * point[0] + cos * point[1], state[2]]
    });
    let poses: Vec<[f64; 3]> = seen.collect();
    Ok(PlateLog::measured(&experiment.name, times, &poses, &commands, outcome, settings, seed))
}

/// Sets the amplitude of the period that begins now.
fn renew(experiment: &Experiment, contact: &AreaContact, plate: &mut Imposed, first: bool) -> Result<(), PlateError> {
    let t = contact.time();
    let coordinate = contact.state()[experiment.index()?];
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
        return Err(PlateError::Jump { t });
    }
    Ok(())
}
