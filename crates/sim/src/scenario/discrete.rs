//! Runs of models that are discrete in time.

use super::run::{ScenarioError, ScenarioRun};
use super::setup::Scenario;
use crate::discrete::DiscreteModel;
use crate::model::Model;
use bracketry_system::System;
use std::borrow::Cow;

/// Fraction of a period by which times may differ: they are rounded.
const ROUNDING: f64 = 1e-9;

/// Whether a time is a whole number of periods, at least one.
pub(super) fn is_multiple(time: f64, period: f64) -> bool {
    let steps = time / period;
    steps.round() >= 1.0 && (steps - steps.round()).abs() <= ROUNDING * steps.max(1.0)
}

/// The system for its inputs and outputs alone, where it has no rates: where it is discrete in time, or has algebraic variables.
pub(super) fn for_signals(system: &System) -> Cow<'_, System> {
    if system.period.is_none() && system.algebraic.is_empty() {
        return Cow::Borrowed(system);
    }
    let mut system = system.with_algebraic_states();
    let zero = system.pool.int(0);
    system.dynamics.fill(zero);
    system.period = None;
    Cow::Owned(system)
}

impl Scenario {
    /// The run of a model that is discrete in time and compiled from `system`. The rows are those of every step, or of as many steps
    /// as `sample` is periods long.
    pub(super) fn run_discrete(&self, system: &System, mut model: DiscreteModel) -> Result<ScenarioRun, ScenarioError> {
        let mut signals = Model::new(&for_signals(system), &self.inputs)?;
        let names = system.input_names();
        let sampled: Vec<bool> = names.iter().map(|name| self.inputs.is_sampled(name)).collect();
        let period = model.period();
        // A sample given for the time of a step acts in it, whatever the rounding of both.
        let mut inputs_at = |t: f64| -> Vec<f64> {
            let (exact, after) = (signals.input_values(t), signals.input_values(t + ROUNDING * period));
            let both = exact.into_iter().zip(after).zip(&sampled);
            both.map(|((exact, after), &sampled)| if sampled { after } else { exact }).collect()
        };
        let steps = ((self.end - self.start) / period + ROUNDING).floor().max(0.0) as usize;
        let simulation = model.iterate(self.start, &self.x0, steps, |_, t| inputs_at(t));
        let stride = (self.sample / period).round().max(1.0) as usize;
        let done = simulation.statistics.steps;
        let rows: Vec<usize> = (0..=done).filter(|k| k % stride == 0 || *k == done).collect();
        let times: Vec<f64> = rows.iter().map(|&k| self.start + k as f64 * period).collect();
        let states: Vec<Vec<f64>> =
            times.iter().map(|&t| simulation.trajectory.sample(t + ROUNDING * period)).collect();
        let inputs: Vec<Vec<f64>> = times.iter().map(|&t| inputs_at(t)).collect();
        let outputs = times.iter().zip(&states).map(|(&t, x)| signals.output_values(t, x)).collect();
        Ok(ScenarioRun {
            times,
            states,
            inputs,
            outputs,
            switches: Vec::new(),
            simulation,
            impulses_left_out: Vec::new(),
            breakdown: None,
        })
    }
}
