//! A control problem run on its plant: exact stick–slip friction where the plant has switching functions, a fixed
//! Runge–Kutta method where it is smooth.

use super::control_problem::ControlProblem;
use super::run::ControlRun;
use crate::closed_loop::{Plant, RungeKuttaPlant};
use crate::dynamics::SymbolicDynamics;
use crate::error::MpcError;
use bracketry_sim::{
    DiscreteModel, ExactPlant, Hold, ImplicitModel, InputError, Inputs, Model, Samples, Settings, SimError, Simulation,
    simulate,
};
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
    /// The inputs do not fit the plant.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The equations of the model or of the plant divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] ZeroDenominator),
    /// The recording was refused.
    #[error(transparent)]
    Sim(#[from] SimError),
}

/// A closed loop with what the plant did between the samples.
#[derive(Clone, Debug)]
pub struct Controlled {
    /// Figures, samples, plan.
    pub run: ControlRun,
    /// The plant between the samples, with its modes: the applied inputs once more, recorded.
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
    let smooth = problem.plant.is_smooth() && !delayed;
    let mut plant: Box<dyn Plant> = if smooth {
        let dynamics = Box::new(SymbolicDynamics::new(&problem.plant)?);
        Box::new(RungeKuttaPlant::new(dynamics, problem.plant_substeps))
    } else {
        Box::new(ExactPlant::new(&problem.plant, &problem.x0, &Settings::default())?)
    };
    let run = problem.run_disturbed(plant.as_mut(), |k, _| progress(k))?;
    let mut inputs = Inputs::new();
    let applied = &run.closed_loop.u;
    for (i, name) in problem.plant.input_names().iter().enumerate() {
        let mut times = run.closed_loop.t[..applied.len()].to_vec();
        let mut values: Vec<f64> = applied.iter().map(|u| u[i]).collect();
        if delayed {
            // Nothing was commanded before the run.
            times.insert(0, times.first().copied().unwrap_or(0.0) - problem.ocp.dt);
            values.insert(0, 0.0);
        }
        inputs = inputs.samples(name, Samples::new(times, values, Hold::Previous)?);
    }
    let end = run.closed_loop.t.last().copied().unwrap_or(0.0);
    let settings = Settings { stop: problem.stop.clone(), ..Settings::default() };
    if !problem.plant.algebraic.is_empty() {
        let model = ImplicitModel::new(&problem.plant, &inputs)?;
        let recording = simulate(model, 0.0, &problem.x0, end, &settings)?;
        return Ok(Controlled { run, recording, switches: Vec::new() });
    }
    let model = Model::new(&problem.plant, &inputs)?;
    let switches = model.switch_names().map(str::to_owned).collect();
    let recording = simulate(model, 0.0, &problem.x0, end, &settings)?;
    Ok(Controlled { run, recording, switches })
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
    let start = run.closed_loop.t.first().copied().unwrap_or(0.0);
    let recording = map.iterate(start, &problem.x0, held * applied.len(), |k, _| applied[k / held].clone());
    Ok(Controlled { run, recording, switches: Vec::new() })
}
