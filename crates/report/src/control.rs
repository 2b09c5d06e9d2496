//! A control problem run on its plant: exact stick–slip friction where the plant has switching functions, a fixed
//! Runge–Kutta method where it is smooth.

use bracketry_mpc::{ControlProblem, ControlRun, MpcError, Plant, PlantError, RungeKuttaPlant, SymbolicDynamics};
use bracketry_sim::{
    Breakdown, Hold, InputError, Inputs, Model, Outcome, Samples, Settings, SimError, Simulation, simulate,
};
use bracketry_system::{System, ZeroDenominator};

use crate::simulation;

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

/// A system with set-valued friction as the plant of a control loop.
pub struct ExactPlant {
    plant: bracketry_sim::Plant,
    system: System,
}

impl ExactPlant {
    /// The system at time 0 in state `x0`.
    ///
    /// # Errors
    /// If the system cannot be compiled or the state does not fit.
    pub fn new(system: &System, x0: &[f64]) -> Result<Self, bracketry_sim::PlantError> {
        let plant = bracketry_sim::Plant::new(system, x0, &Settings::default())?;
        Ok(Self { plant, system: system.clone() })
    }
}

impl Plant for ExactPlant {
    fn step(&mut self, _t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        if self.plant.state() != x {
            self.plant.set_state(x)?;
        }
        match self.plant.step(u, dt)? {
            Outcome::Finished => {
                x.copy_from_slice(self.plant.state());
                Ok(())
            }
            Outcome::Stopped { reason, t, state } => {
                let breakdown = Breakdown::find(&self.system, self.plant.model(), &reason, t, &state);
                let why = breakdown.map_or_else(|| reason.to_string(), |b| simulation::breakdown(&self.system, &b));
                Err(format!("{why} (t = {t} s)").into())
            }
        }
    }
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
    problem.system.check_denominators()?;
    problem.plant.check_denominators()?;
    let mut plant_system = problem.plant.clone();
    // Delays act within a sample, which is for the simulator too.
    let delayed = plant_system.delay_values().iter().any(|d| *d != Some(0.0));
    let smooth = plant_system.set_valued_form().switches.is_empty() && !delayed;
    let mut plant: Box<dyn Plant> = if smooth {
        let dynamics = Box::new(SymbolicDynamics::new(&problem.plant)?);
        Box::new(RungeKuttaPlant::new(dynamics, problem.plant_substeps))
    } else {
        Box::new(ExactPlant::new(&problem.plant, &problem.x0)?)
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
    let model = Model::new(&problem.plant, &inputs)?;
    let switches = model.switch_names().map(str::to_owned).collect();
    let end = run.closed_loop.t.last().copied().unwrap_or(0.0);
    let settings = Settings { stop: problem.stop.clone(), ..Settings::default() };
    let recording = simulate(model, 0.0, &problem.x0, end, &settings)?;
    Ok(Controlled { run, recording, switches })
}
