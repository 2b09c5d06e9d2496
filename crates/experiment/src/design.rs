//! What all experiments have in common.

use crate::noise::ColumnNoise;
use crate::options::Limit;
use crate::setup::{InputLimits, Setup};
use crate::signals::Signals;
use bracketry_system::Quantities;

/// What is common to all experiments: the inputs, what they keep, and what was assumed of the measurements.
#[derive(Clone, Debug)]
pub struct Design {
    /// Units and labels of the model.
    pub quantities: Quantities,
    /// The inputs.
    pub signals: Signals,
    /// Limits that are kept on the exact models: of the inputs, then of their rates, then of states.
    pub limits: Vec<Limit>,
    /// Measured columns with their noise.
    pub noise: Vec<ColumnNoise>,
    /// Time between two samples, in the unit of time of the model.
    pub sample: f64,
    /// Starts of the optimization, over all rounds.
    pub starts: usize,
    /// Whether the time limit ended the search: other starts and other refits might have changed the result.
    pub is_cut: bool,
}

impl Design {
    pub(crate) fn new(setup: &Setup, signals: Signals, noise: Vec<ColumnNoise>, starts: usize, is_cut: bool) -> Self {
        let inputs = setup.inputs.iter().map(|u| Limit::new(&u.name, u.range[0], u.range[1]));
        let rate = |u: &InputLimits| u.rate.map(|r| Limit::new(&format!("der({})", u.name), r[0], r[1]));
        let limits = inputs.chain(setup.inputs.iter().filter_map(rate)).chain(setup.states.iter().cloned()).collect();
        Self { quantities: setup.quantities.clone(), signals, limits, noise, sample: setup.sample, starts, is_cut }
    }

    /// Length of the experiment, in the unit of time of the model.
    pub fn duration(&self) -> f64 {
        self.signals.times.last().copied().unwrap_or(0.0)
    }
}
