//! The published two-step way: first the orientation, then the position, one coordinate after the other.

use crate::{Experiment, PlateError};
use bracketry_sim::{Model, Outcome, Settings, Stepper, Trajectory};
use bracketry_system::System;

/// Time after the last stage in which what slides comes to rest, in seconds.
const SETTLING: f64 = 1.0;

/// One stage of the two-step way.
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

/// What the two-step way achieved.
#[derive(Debug, Clone)]
pub struct TwoStep {
    /// The stages, in order.
    pub stages: Vec<Stage>,
    /// States at any time, until everything that friction can stop has stopped.
    pub trajectory: Trajectory,
    /// How the simulation ended.
    pub outcome: Outcome,
    /// Errors `q − q_desired` of the stages' coordinates at the end, after settling.
    pub final_errors: Vec<f64>,
    /// Spin `w` that remains at the end, in rad/s.
    pub remaining_spin: f64,
}

/// Runs the experiments one after the other on one plant, each stopped as soon as its coordinate crosses its target, or
/// after `limit` seconds. Each stage starts its inputs anew (`ξ` from zero); when one is stopped, the plate's
/// accelerations cease and the tilt is level.
///
/// # Errors
/// [`PlateError`] if the model does not fit.
pub fn two_step(
    system: &System,
    experiments: &[Experiment],
    x0: &[f64],
    limit: f64,
    settings: &Settings,
) -> Result<TwoStep, PlateError> {
    let spin = system.state_index("w").ok_or(PlateError::NoState { name: "w" })?;
    let mut state = x0.to_vec();
    let mut now = 0.0;
    let mut stages = Vec::new();
    let mut trajectory: Option<Trajectory> = None;
    let mut outcome = Outcome::Finished;
    let mut join = |piece: Trajectory| match &mut trajectory {
        None => trajectory = Some(piece),
        Some(all) => all.append(&piece),
    };
    for experiment in experiments {
        let index = experiment.index(system)?;
        let model = Model::new(system, &experiment.inputs(now))?;
        let mut stepper = Stepper::new(model, now, &state, settings)?;
        let way = (experiment.target - state[index]).signum();
        let (from, last, mut met) = (now, now + limit, false);
        let mut period = 0u32;
        while outcome.is_finished() && !met && stepper.time() < last {
            let amplitude = experiment.amplitude(stepper.state()[index] - experiment.target);
            stepper.system_mut().set_live("A", amplitude);
            period += 1;
            let start = stepper.clone();
            let end = (from + f64::from(period) * experiment.period).min(last);
            let (piece, ended) = stepper.record(end)?;
            outcome = ended;
            if let Some(t) = crossing(&piece, index, experiment.target, way) {
                stepper = start;
                let (piece, _) = stepper.record(t)?;
                join(piece);
                (met, outcome) = (true, Outcome::Finished);
            } else {
                join(piece);
            }
        }
        now = stepper.time();
        state.copy_from_slice(stepper.state());
        stages.push(Stage { name: experiment.name.clone(), from, to: now, met });
        if !outcome.is_finished() {
            break;
        }
    }
    if outcome.is_finished() {
        let mut rest = Stepper::new(Model::new(system, &bracketry_sim::Inputs::new())?, now, &state, settings)?;
        let (piece, ended) = rest.record(now + SETTLING)?;
        outcome = ended;
        state.copy_from_slice(rest.state());
        join(piece);
    }
    let final_errors =
        experiments.iter().map(|e| e.index(system).map(|index| state[index] - e.target)).collect::<Result<_, _>>()?;
    let Some(trajectory) = trajectory else {
        return Err(PlateError::NoExperiment);
    };
    Ok(TwoStep { stages, trajectory, outcome, final_errors, remaining_spin: state[spin] })
}

/// First time at which a coordinate passes its target in the direction `way`, to 1 ns.
fn crossing(trajectory: &Trajectory, index: usize, target: f64, way: f64) -> Option<f64> {
    let passed = |t: f64| way * (trajectory.sample(t)[index] - target) >= 0.0;
    let mut before = trajectory.start();
    for t in trajectory.times() {
        if passed(t) {
            let (mut a, mut b) = (before, t);
            while b - a > 1e-9 {
                let m = 0.5 * (a + b);
                if passed(m) { b = m } else { a = m }
            }
            return Some(b);
        }
        before = t;
    }
    None
}
