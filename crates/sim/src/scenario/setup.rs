//! What a simulation is given.

use crate::model::Inputs;
use bracketry_symbolic::Rational;
use bracketry_system::System;

/// A simulation to run: where it starts, what drives it, how long.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// Initial state, in the order of the model.
    pub x0: Vec<f64>,
    /// What drives the inputs; inputs that are not mentioned are zero.
    pub inputs: Inputs,
    /// End time in seconds; the simulation starts at `start`.
    pub end: f64,
    /// Start time in seconds.
    pub start: f64,
    /// Distance in seconds between the rows of the result.
    pub sample: f64,
    /// Parameter values that replace those of the model.
    pub parameters: Vec<(String, Rational)>,
}

/// A [`Scenario`], and what its table did not say.
#[derive(Clone, Debug)]
pub struct SampledScenario {
    /// The scenario.
    pub scenario: Scenario,
    /// Columns that are no input, nor a derivative of one that the model uses.
    pub ignored: Vec<String>,
    /// Inputs without any column: they and their derivatives are zero.
    pub held_at_zero: Vec<String>,
}

impl Scenario {
    /// The inputs that nothing drives: they and their derivatives are zero.
    pub fn inputs_at_zero(&self, system: &System) -> Vec<String> {
        system.input_names().into_iter().filter(|name| !self.inputs.mentions(name)).collect()
    }
}

/// The model's point, or zeros.
pub(super) fn initial_state(system: &System) -> Vec<f64> {
    system.point_values().map_or_else(|| vec![0.0; system.states.len()], |(x, _)| x)
}
