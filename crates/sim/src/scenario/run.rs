//! The run of a scenario, with samples at regular times.

use super::setup::Scenario;
use crate::breakdown::Breakdown;
use crate::discrete::DiscreteModel;
use crate::model::{InputError, Model};
use crate::outcome::Outcome;
use crate::settings::{SimError, SimulationSettings};
use crate::simulate::{Simulation, simulate};
use bracketry_symbolic::CompileError;
use bracketry_system::{FileError, System, ZeroDenominator};

/// A simulation that cannot be set up.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file is wrong.
    #[error(transparent)]
    File(#[from] FileError),
    /// The inputs do not fit the model.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The equations cannot be compiled.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// The integrator was misused.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] ZeroDenominator),
}

/// A simulation with samples at regular times.
#[derive(Clone, Debug)]
pub struct ScenarioRun {
    /// Sample times in seconds.
    pub times: Vec<f64>,
    /// States at these times.
    pub states: Vec<Vec<f64>>,
    /// Inputs at these times, as they are commanded, before the delays of the model; not a number where only derivatives of an
    /// input are given.
    pub inputs: Vec<Vec<f64>>,
    /// Outputs of the model at these times, with `sign(0) = 0`.
    pub outputs: Vec<Vec<f64>>,
    /// Printed switching functions.
    pub switches: Vec<String>,
    /// Dense output and mode changes, how it ended, work done.
    pub simulation: Simulation,
    /// Input derivatives, by input and order, whose impulses are left out because the input's expression jumps or has
    /// kinks: what the model would do there is not simulated.
    pub impulses_left_out: Vec<(String, u32)>,
    /// What the equations do where the simulation stopped before its end, as far as that was found.
    pub breakdown: Option<Breakdown>,
}

impl Scenario {
    /// Integrates `system` with exact stick–slip friction.
    ///
    /// # Errors
    /// If inputs and system do not fit. Blow-up and chattering are outcomes, not errors.
    pub fn run(&self, system: &System, settings: &SimulationSettings) -> Result<ScenarioRun, ScenarioError> {
        let mut system = system.clone();
        for (name, value) in &self.parameters {
            system.set_parameter(name, value.clone());
        }
        system.check_denominators()?;
        if let Some(map) = DiscreteModel::of(&system)? {
            return self.run_discrete(&system, map);
        }
        if !system.algebraic.is_empty() {
            return self.run_implicit(&system, settings);
        }
        let mut model = Model::new(&system, &self.inputs)?;
        let simulation = simulate(model.clone(), self.start, &self.x0, self.end, settings)?;
        let (end, breakdown) = match &simulation.outcome {
            Outcome::Finished => (self.end, None),
            Outcome::Stopped { reason, t, state } => (*t, Breakdown::find(&system, &model, reason, *t, state)),
        };
        let times = self.times_to(end);
        let states: Vec<Vec<f64>> = times.iter().map(|&t| simulation.trajectory.sample(t)).collect();
        let outputs = times.iter().zip(&states).map(|(&t, x)| model.output_values(t, x)).collect();
        let unknown: Vec<bool> = system.input_names().iter().map(|n| self.inputs.only_derivatives(n)).collect();
        // As they are commanded: the record of a run, given back as inputs, has to give the same run.
        system.input_delays.clear();
        let mut commands = Model::new(&system, &self.inputs)?;
        let mut commanded = |t: f64| {
            let values = commands.input_values(t);
            values.into_iter().zip(&unknown).map(|(v, &unknown)| if unknown { f64::NAN } else { v }).collect()
        };
        Ok(ScenarioRun {
            inputs: times.iter().map(|&t| commanded(t)).collect(),
            times,
            states,
            outputs,
            switches: model.switch_names().map(str::to_owned).collect(),
            simulation,
            impulses_left_out: model.impulses_left_out().to_vec(),
            breakdown,
        })
    }

    /// The times of the rows of a run that ends at `end`.
    pub(super) fn times_to(&self, end: f64) -> Vec<f64> {
        let count = ((end - self.start) / self.sample + 1e-9).floor() as usize;
        let mut times: Vec<f64> = (0..=count).map(|i| self.start + i as f64 * self.sample).collect();
        if end - times[count] > 1e-9 * self.sample {
            times.push(end);
        }
        times
    }
}
