//! Runs of models with algebraic variables.

use super::run::{ScenarioError, ScenarioRun};
use super::setup::Scenario;
use crate::breakdown::Breakdown;
use crate::implicit_model::ImplicitModel;
use crate::outcome::Outcome;
use crate::settings::SimulationSettings;
use crate::simulate::simulate;
use bracketry_system::System;

impl Scenario {
    /// The run of a model with algebraic variables, its parameters set.
    pub(super) fn run_implicit(
        &self,
        system: &System,
        settings: &SimulationSettings,
    ) -> Result<ScenarioRun, ScenarioError> {
        let mut model = ImplicitModel::new(system, &self.inputs)?;
        let simulation = simulate(model.clone(), self.start, &self.x0, self.end, settings)?;
        let (end, breakdown) = match &simulation.outcome {
            Outcome::Finished => (self.end, None),
            Outcome::Stopped { t, state, .. } => (*t, model.clone().failure_beyond(*t, state).map(Breakdown::NoRoot)),
        };
        let times = self.times_to(end);
        let states: Vec<Vec<f64>> = times.iter().map(|&t| simulation.trajectory.sample(t)).collect();
        let outputs = times.iter().zip(&states).map(|(&t, x)| model.output_values(t, x)).collect();
        let inputs = times.iter().map(|&t| model.input_values(t)).collect();
        Ok(ScenarioRun {
            times,
            states,
            inputs,
            outputs,
            switches: Vec::new(),
            simulation,
            impulses_left_out: Vec::new(),
            breakdown,
        })
    }
}
