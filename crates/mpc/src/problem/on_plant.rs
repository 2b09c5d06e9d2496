//! A control problem run on its plant: exact stick–slip friction where the plant has switching functions, a fixed
//! Runge–Kutta method where it is smooth and that is accurate.

use super::control_problem::ControlProblem;
use super::notes::Note;
use super::run::ControlRun;
use crate::closed_loop::SmoothPlant;
use crate::error::MpcError;
use bracketry_sim::{DiscreteModel, ExactPlant, Outcome, Simulation, SimulationSettings, Trajectory};
use bracketry_system::ZeroDenominator;

/// A control problem that could not be run.
#[derive(Debug, thiserror::Error)]
pub enum ControlError {
    /// The problem contradicts itself or the plant stopped.
    #[error(transparent)]
    Mpc(#[from] MpcError),
    /// The plant cannot be simulated.
    #[error(transparent)]
    Plant(#[from] bracketry_sim::PlantError),
    /// The equations of the model or of the plant divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] ZeroDenominator),
}

/// A closed loop with what the plant did between the samples.
#[derive(Clone, Debug)]
pub struct Controlled {
    /// Figures, samples, plan.
    pub run: ControlRun,
    /// The motion of the plant in this loop, also between the samples, with its modes.
    pub recording: Simulation,
    /// Names of the plant's switching functions.
    pub switches: Vec<String>,
}

/// Runs the closed loop of a problem.
///
/// # Errors
/// [`ControlError`]; infeasible programs, fallbacks and missed targets are figures of the report instead.
pub fn control(problem: &ControlProblem) -> Result<Controlled, ControlError> {
    control_watched(problem, |_| {})
}

/// [`control`], with `progress` called at the start of every sample with its number.
///
/// # Errors
/// As [`control`].
pub fn control_watched(problem: &ControlProblem, mut progress: impl FnMut(usize)) -> Result<Controlled, ControlError> {
    let problem = &*problem.with_free_values()?;
    problem.system.check_denominators()?;
    problem.plant.check_denominators()?;
    if let Some(map) = DiscreteModel::of(&problem.plant).map_err(MpcError::from)? {
        return control_map(problem, map, progress);
    }
    // Delays act within a sample, which is for the simulator too.
    let delayed = problem.plant.delay_values().iter().any(|d| *d != Some(0.0));
    if problem.plant.is_smooth() && !delayed {
        return control_smooth(problem, progress);
    }
    let mut plant = ExactPlant::new(&problem.plant, &problem.x0, &SimulationSettings::default())?;
    plant.set_past_inputs(&problem.first_input())?;
    plant.start_recording();
    let run = problem.run_disturbed(&mut plant, |k, _| progress(k))?;
    let switches = plant.model().switch_names().map(str::to_owned).collect();
    let statistics = plant.statistics();
    let recording = Simulation { trajectory: plant.take_recording(), outcome: Outcome::Finished, statistics };
    Ok(Controlled { run, recording, switches })
}

/// [`control_watched`] on a plant without switches.
fn control_smooth(problem: &ControlProblem, mut progress: impl FnMut(usize)) -> Result<Controlled, ControlError> {
    let sizes = &problem.ocp.sizes()[..problem.plant.states.len()];
    let mut plant = SmoothPlant::new(&problem.plant, problem.plant_substeps, sizes, &problem.stop)?;
    let start = problem.ocp.time(0, 0);
    plant.start_recording(start, &problem.x0);
    let mut run = problem.run_disturbed(&mut plant, |k, _| progress(k))?;
    run.report.notes.extend(plant.refined().map(Note::PlantRefined));
    let statistics = plant.statistics();
    let trajectory = plant.take_recording().unwrap_or_else(|| Trajectory::starting_at(start, &problem.x0));
    let recording = Simulation { trajectory, outcome: Outcome::Finished, statistics };
    Ok(Controlled { run, recording, switches: Vec::new() })
}

/// [`control_watched`] on a plant that is discrete in time.
fn control_map(
    problem: &ControlProblem,
    mut map: DiscreteModel,
    mut progress: impl FnMut(usize),
) -> Result<Controlled, ControlError> {
    let run = problem.run_disturbed(&mut map.clone(), |k, _| progress(k))?;
    let applied = &run.closed_loop.u;
    let held = (problem.ocp.dt / map.period()).round().max(1.0) as usize;
    let mut recording: Option<Simulation> = None;
    for (k, u) in applied.iter().enumerate() {
        let sample = map.iterate(run.closed_loop.t[k], &run.closed_loop.x[k], held, |_, _| u.clone());
        match &mut recording {
            Some(so_far) => {
                so_far.trajectory.append(&sample.trajectory);
                so_far.statistics.steps += sample.statistics.steps;
                so_far.statistics.rhs += sample.statistics.rhs;
            }
            None => recording = Some(sample),
        }
    }
    let recording = recording.unwrap_or_else(|| map.iterate(0.0, &problem.x0, 0, |_, _| Vec::new()));
    Ok(Controlled { run, recording, switches: Vec::new() })
}
