//! What a laboratory would record of the true plant.

use bracketry::diagnose::{DiagnoseError, Record, RecordSettings};
use bracketry::plate::PlateKinematics;
use bracketry::plate::area::AreaOutcome;
use bracketry::plate::control::RESOLUTION;
use bracketry::plate::experiment::Experiment;
use bracketry::plate::recording::{PlateMismatch, RecordingError, SyntheticLog, multisine, synthetic_log};
use bracketry::system::System;
use rayon::prelude::*;

use super::on_plant::MoveOnPlant;
use super::settings::StorySettings;

/// Where identification runs start: x, y (m), at rest.
const START: [f64; 6] = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
/// Experiment 1 is made a second time with so many times its displacement, for so long (s): the body spins as fast as in a move, so that its
/// spin shows in its friction.
const WIDER: f64 = 3.0;
const WIDER_SECONDS: f64 = 4.0;

/// A run that is still to be made.
type Recorded<'a> = &'a (dyn Fn() -> Result<SyntheticLog, RecordingError> + Sync);

/// The logs of a multisine, of experiment 1 as published and with a wider displacement, and, last, of a second multisine to measure the gain on, made side by side.
///
/// # Errors
/// [`RecordingError`] for settings without meaning, or where no multisine keeps the object on the plate.
pub fn identification_runs(settings: &StorySettings) -> Result<Vec<SyntheticLog>, RecordingError> {
    let (plant, seconds, seed) = (&settings.plant, settings.seconds, settings.seed);
    let run = |experiment: &Experiment, seconds: f64, noise: u64| {
        synthetic_log(experiment, START, seconds, &PlateMismatch::None, plant, noise)
    };
    // The multisine of the held-out log is drawn apart.
    let excited = |seed: u64, noise: u64| run(&multisine(START, seconds, plant, seed)?, seconds, noise);
    let published = Experiment::orientation();
    let wider = Experiment { displacement: format!("{WIDER}*{}", published.displacement), ..published.clone() };
    let runs: [(&str, Recorded<'_>); 4] = [
        ("multisine", &|| excited(seed, noise_of(seed, 1))),
        ("experiment 1", &|| run(&published, seconds, noise_of(seed, 2))),
        ("experiment 1, wider", &|| run(&wider, seconds.min(WIDER_SECONDS), noise_of(seed, 3))),
        ("multisine, held out", &|| excited(!seed, !seed)),
    ];
    runs.into_par_iter()
        .map(|(name, record)| {
            let mut log = record()?;
            name.clone_into(&mut log.log.name);
            Ok(log)
        })
        .collect()
}

/// Noise is drawn apart for each log.
fn noise_of(seed: u64, log: u64) -> u64 {
    seed.wrapping_mul(4).wrapping_add(log)
}

/// The closed loop as the camera saw it.
pub fn log_of_move(moved: &MoveOnPlant, settings: &StorySettings) -> SyntheticLog {
    let every = (1.0 / (settings.plant.rate * RESOLUTION)).round().max(1.0) as usize;
    let inputs = &moved.run.closed_loop;
    let rows = moved.closed_loop.iter().enumerate().step_by(every).map(|(k, x)| {
        let t = k as f64 * RESOLUTION;
        let sample = inputs.t.partition_point(|&s| s <= t + 1e-9).clamp(1, inputs.u.len().max(1)) - 1;
        let u = inputs.u.get(sample).map_or([0.0; 2], |u| [u[0], u[1]]);
        let plate = PlateKinematics {
            displacement: x[6],
            velocity: x[7],
            acceleration: u[0],
            tilt: x[8],
            tilt_rate: x[9],
            tilt_acceleration: u[1],
        };
        (t, [x[0], x[1], x[2]], plate)
    });
    let outcome = moved.stopped.unwrap_or(AreaOutcome::Finished);
    SyntheticLog::measured("closed loop", rows, outcome, &settings.plant, noise_of(settings.seed, 0))
}

/// The logs as records of the model's diagnosis.
pub(super) fn records(logs: &[SyntheticLog], model: &System) -> Result<Vec<Record>, DiagnoseError> {
    let read = |SyntheticLog { log, .. }: &SyntheticLog| {
        Record::from_columns(&log.name, log.t.clone(), log.by_name(), model, &RecordSettings::default())
    };
    logs.iter().map(read).collect()
}
