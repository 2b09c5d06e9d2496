//! The displacement of a loop, on the exact plant.

use bracketry_sim::{Hold, InputError, Model, Path, SimulationSettings, Stepper, Tangent};
use bracketry_symbolic::StopFlag;

use super::model::RestModel;
use super::strokes::{CLOSING, Loop};
use crate::roll_out::RollOut;
use crate::signals::Signals;

/// Least number of steps of a motion along which derivatives are propagated.
const STEPS: f64 = 400.0;
/// A velocity below this is rest.
const REST: f64 = 1e-9;
/// Pauses that are tried after a loop until everything rests, in durations of the loop.
const PAUSES: [f64; 3] = [1.0, 4.0, 16.0];
/// Pauses are not shortened further than to this part.
const SHORTEST_PAUSE: f64 = 0.1;
/// Steps of the secant method.
const SECANTS: usize = 12;

/// The plant that loops are tried on.
pub(crate) struct Plant {
    roll_out: RollOut,
    stop: StopFlag,
}

impl Plant {
    pub(crate) fn new(model: &RestModel, stop: &StopFlag) -> Result<Self, InputError> {
        Ok(Plant { roll_out: RollOut::new(&model.system, Hold::Previous, stop)?, stop: stop.clone() })
    }

    /// The change of the coordinates by a loop with all durations times `scale`, with the signals including the pause in
    /// which everything comes to rest; `None` where it does not.
    pub(crate) fn displaced(
        &mut self,
        model: &RestModel,
        from: &[f64],
        stroke: &Loop,
        scale: f64,
    ) -> Option<Displaced> {
        let start = at_rest(model, from);
        let factor = self.closing_factor(model, &start, stroke, scale)?;
        let closed = stroke.closed(factor);
        for pause in PAUSES {
            let signals = closed.signals(model, scale, pause * stroke.duration() * scale.max(SHORTEST_PAUSE));
            let end = self.roll_out.end(&start, &signals)?;
            let is_back = (model.own_states..start.len()).all(|k| (end[k] - start[k]).abs() < REST);
            if is_back && model.velocities.iter().all(|&k| end[k].abs() < REST) {
                let change = model.coordinates.iter().map(|&k| end[k] - start[k]).collect();
                return Some(Displaced { change, signals, closed });
            }
        }
        None
    }

    /// The derivative of the displacement under these inputs by the coordinates at the start, `[from][to]`, by the linear maps
    /// along the motion; `None` where it cannot be followed.
    pub(crate) fn sensitivity(&self, model: &RestModel, from: &[f64], signals: &Signals) -> Option<Vec<Vec<f64>>> {
        let inputs = signals.inputs(&model.system.input_names()).ok()?;
        let plant = Model::differentiable(&model.system, &inputs, &[]).ok()?;
        let mut settings = SimulationSettings::default().with_max_step(signals.duration() / STEPS);
        settings.stop = self.stop.clone();
        let mut stepper = Stepper::new(plant, 0.0, &at_rest(model, from), &settings).ok()?;
        stepper.follow(Path::default());
        if !stepper.advance(signals.duration()).is_finished() {
            return None;
        }
        let (path, mut tangent) = (stepper.take_path(), Tangent::default());
        if !stepper.system_mut().tangent(&path, &mut tangent) {
            return None;
        }
        let n = model.system.states.len();
        let mut derivatives = Vec::new();
        for &k in &model.coordinates {
            let mut change = vec![0.0; n];
            change[k] = 1.0;
            for piece in 0..tangent.len() {
                tangent.propagate(piece, &mut change, &[], &mut Vec::new());
            }
            change[k] -= 1.0;
            derivatives.push(model.coordinates.iter().map(|&to| change[to]).collect());
        }
        Some(derivatives)
    }

    /// The factor for which the velocity without friction ends at zero, by the secant method.
    fn closing_factor(&mut self, model: &RestModel, start: &[f64], stroke: &Loop, scale: f64) -> Option<f64> {
        let Some(closing) = stroke.closing else { return Some(1.0) };
        let mut left = |factor: f64| {
            let signals = stroke.closed(factor).signals(model, scale, stroke.duration() * scale.max(SHORTEST_PAUSE));
            Some(self.roll_out.end(start, &signals)?[closing.velocity])
        };
        let (mut a, mut b) = (0.95, 1.0);
        let (mut at_a, mut at_b) = (left(a)?, left(b)?);
        for _ in 0..SECANTS {
            if at_b.abs() < 0.1 * REST {
                return (CLOSING..=1.0 / CLOSING).contains(&b).then_some(b);
            }
            let next = b - at_b * (b - a) / (at_b - at_a);
            if !next.is_finite() {
                return None;
            }
            (a, at_a) = (b, at_b);
            (b, at_b) = (next, left(next)?);
        }
        None
    }
}

/// What a loop does.
pub(crate) struct Displaced {
    /// Changes of the coordinates.
    pub(crate) change: Vec<f64>,
    /// The inputs with the pause.
    pub(crate) signals: Signals,
    /// The loop with what closes it.
    pub(crate) closed: Loop,
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
