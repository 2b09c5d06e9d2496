//! The published two-step method: first the orientation, then the position, one coordinate after the other.

use super::held_amplitude::HeldAmplitude;
use super::protocol::Experiment;
use super::run::six;
use crate::driven::Course;
use crate::driven::crossing;
use crate::motion::Drive;
use crate::{DrivenObject, ModelObject, PlateError};
use bracketry_sim::{Outcome, SimulationSettings, Trajectory};
use bracketry_system::System;

/// Time after the last stage in which what slides comes to rest, in seconds.
const SETTLING: f64 = 1.0;

/// One stage of the two-step method.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Name of its experiment.
    pub name: String,
    /// When it began, in seconds.
    pub from: f64,
    /// When it was stopped.
    pub to: f64,
    /// Whether its target was met; if not, it ran out of time.
    pub met: bool,
}

/// What the two-step method achieved.
#[derive(Debug, Clone)]
pub struct TwoStep<C = Trajectory> {
    /// The stages, in order.
    pub stages: Vec<Stage>,
    /// States at any time, until everything that friction can stop has stopped.
    pub trajectory: C,
    /// How the simulation ended.
    pub outcome: Outcome,
    /// Errors `q − q_desired` of the stages' coordinates at the end, after settling.
    pub final_errors: Vec<f64>,
    /// Spin `w` that remains at the end, in rad/s.
    pub remaining_spin: f64,
}

/// Runs the experiments one after the other on a model in the form of differential equations; see [`two_step_on`].
///
/// # Errors
/// [`PlateError`] if the model does not fit.
pub fn two_step(
    system: &System,
    experiments: &[Experiment],
    x0: &[f64],
    limit: f64,
    settings: &SimulationSettings,
) -> Result<TwoStep, PlateError> {
    two_step_on(&mut ModelObject::new(system, six(x0)?, settings)?, experiments, limit)
}

/// Runs the experiments one after the other on one object, each stopped as soon as its coordinate crosses its target, or
/// after `limit` seconds. Each stage starts its inputs anew (`ξ` from zero); when one is stopped, the plate's
/// accelerations cease and the tilt is level.
///
/// # Errors
/// [`PlateError`] if the experiments do not fit the object.
pub fn two_step_on<P: DrivenObject>(
    object: &mut P,
    experiments: &[Experiment],
    limit: f64,
) -> Result<TwoStep<P::Course>, PlateError> {
    if experiments.is_empty() {
        return Err(PlateError::NoExperiment);
    }
    let (mut trajectory, mut outcome) = object.record(object.time())?;
    let mut stages = Vec::new();
    for experiment in experiments {
        let index = experiment.index();
        let (from, last, mut met) = (object.time(), object.time() + limit, false);
        let mut held = HeldAmplitude::start(experiment, object)?;
        let direction = (experiment.target - object.state()[index]).signum();
        let mut period = 0u32;
        while outcome.is_finished() && !met && object.time() < last {
            held.update(object)?;
            period += 1;
            let start = object.clone();
            let end = (from + f64::from(period) * experiment.period).min(last);
            let (mut piece, mut ended) = object.record(end)?;
            if let Some(t) = crossing(&piece, index, experiment.target, direction) {
                *object = start;
                (piece, ended) = object.record(t)?;
                met = true;
            }
            trajectory.join(&piece);
            outcome = ended;
        }
        stages.push(Stage { name: experiment.name.clone(), from, to: object.time(), met });
        if !outcome.is_finished() {
            break;
        }
    }
    if outcome.is_finished() {
        object.drive(&Drive::still())?;
        let (piece, ended) = object.record(object.time() + SETTLING)?;
        outcome = ended;
        trajectory.join(&piece);
    }
    let state = object.state();
    let final_errors = experiments.iter().map(|e| state[e.index()] - e.target).collect();
    Ok(TwoStep { stages, trajectory, outcome, final_errors, remaining_spin: state[5] })
}
