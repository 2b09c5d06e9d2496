//! The displacement of a loop, on the exact plant.

use bracketry_sim::{Hold, InputError};
use bracketry_symbolic::StopFlag;

use super::model::RestModel;
use super::strokes::Loop;
use crate::roll_out::RollOut;
use crate::signals::Signals;

/// A velocity below this is rest.
const REST: f64 = 1e-9;
/// Pauses that are tried after a loop until everything rests, in durations of the loop.
const PAUSES: [f64; 3] = [1.0, 4.0, 16.0];

/// The plant that loops are tried on.
pub(crate) struct Plant {
    roll_out: RollOut,
}

impl Plant {
    pub(crate) fn new(model: &RestModel, stop: &StopFlag) -> Result<Self, InputError> {
        Ok(Plant { roll_out: RollOut::new(&model.system, Hold::Previous, stop)? })
    }

    /// The change of the coordinates by a loop with all durations times `scale`, with the signals including the pause in
    /// which everything comes to rest; `None` where it does not.
    pub(crate) fn displaced(
        &mut self,
        model: &RestModel,
        from: &[f64],
        stroke: &Loop,
        scale: f64,
    ) -> Option<(Vec<f64>, Signals)> {
        let start = at_rest(model, from);
        for pause in PAUSES {
            let signals = stroke.signals(model, scale, pause * stroke.duration() * scale.max(0.1));
            let end = self.roll_out.end(&start, &signals)?;
            let integrators = model.own_states..start.len();
            let is_back = integrators.into_iter().all(|k| (end[k] - start[k]).abs() < REST);
            if is_back && model.velocities.iter().all(|&k| end[k].abs() < REST) {
                let change = model.coordinates.iter().map(|&k| end[k] - start[k]).collect();
                return Some((change, signals));
            }
        }
        None
    }
}

/// The state at rest with these coordinates.
pub(crate) fn at_rest(model: &RestModel, coordinates: &[f64]) -> Vec<f64> {
    let mut state = vec![0.0; model.system.states.len()];
    for (&k, &q) in model.coordinates.iter().zip(coordinates) {
        state[k] = q;
    }
    for channel in &model.channels {
        let place = channel.symbols[0].and_then(|s| model.system.states.iter().position(|&x| x == s));
        if let Some(k) = place {
            state[k] = channel.home.value;
        }
    }
    state
}
