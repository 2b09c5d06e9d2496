//! The motion of the model under given inputs.

use bracketry_sim::{Hold, InputError, Model, Simulation, SimulationSettings, simulate};
use bracketry_symbolic::StopFlag;
use bracketry_system::System;

use crate::signals::Signals;

/// Most steps of one simulation.
const MAX_STEPS: usize = 200_000;
/// Tolerances of a simulation that counts.
const TIGHT: (f64, f64) = (1e-11, 1e-13);

/// The model compiled for inputs of one kind.
#[derive(Clone)]
pub(crate) struct RollOut {
    model: Model,
    names: Vec<String>,
    settings: SimulationSettings,
}

impl RollOut {
    pub(crate) fn new(system: &System, hold: Hold, stop: &StopFlag) -> Result<Self, InputError> {
        let names = system.input_names();
        let zeros = vec![vec![0.0; names.len()]; 2];
        let rest = Signals { times: vec![0.0, 1.0], values: zeros, hold };
        let model = Model::new(system, &rest.inputs(&names)?)?;
        let mut settings = SimulationSettings::default().with_tolerance(TIGHT.0, TIGHT.1);
        settings.max_steps = MAX_STEPS;
        settings.stop = stop.clone();
        Ok(RollOut { model, names, settings })
    }

    /// The motion; `None` where the inputs are not finite.
    pub(crate) fn run(&mut self, from: &[f64], signals: &Signals) -> Option<Simulation> {
        if !signals.is_finite() || signals.duration() <= 0.0 {
            return None;
        }
        for (j, name) in self.names.iter().enumerate() {
            self.model.set_samples(name, 0, signals.column(j).ok()?);
        }
        simulate(self.model.clone(), 0.0, from, signals.duration(), &self.settings).ok()
    }

    /// The state at the end; `None` where the simulation does not get there.
    pub(crate) fn end(&mut self, from: &[f64], signals: &Signals) -> Option<Vec<f64>> {
        let run = self.run(from, signals)?;
        run.outcome.is_finished().then(|| run.trajectory.final_state().to_vec())
    }
}

/// The largest difference.
pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most, (a, b)| (a - b).abs().max(most))
}
