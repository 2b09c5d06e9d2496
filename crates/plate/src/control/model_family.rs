//! The motion of the object as a function of what is not known of it, from exact simulations side by side.

use super::interface::Command;
use super::learned::{LATENCY, OF_OBJECT, PARAMETERS, Parameters, object_of};
use super::replay::Replay;
use crate::{Object, PlateError, PlateKinematics};
use std::collections::VecDeque;

/// Steps from the middle up to which the motion is a parabola of a parameter; beyond, it is its tangent.
const PARABOLA: f64 = 1.2;
/// States kept for measurements that come late: as many samples as the longest latency has, and two more.
const KEPT: usize = 10;

/// Simulations with the parameters in the middle, and one step to either side for each that is not known: the motion as
/// a parabola of each parameter.
#[derive(Debug, Clone)]
pub(super) struct ModelFamily {
    middle: Parameters,
    /// Distance to the simulations on either side; 0 for what is known.
    steps: [f64; OF_OBJECT],
    /// The one in the middle, then those below and above for each parameter with a step.
    models: Vec<Replay>,
    /// States of the models at the latest samples, the last one first.
    past: VecDeque<Vec<[f64; 6]>>,
}

/// A pose with its derivatives with respect to the parameters.
pub(super) struct Seen {
    pub(super) pose: [f64; 3],
    pub(super) slopes: [[f64; PARAMETERS]; 3],
}

impl ModelFamily {
    pub(super) fn new(first: &Object, middle: Parameters, steps: [f64; OF_OBJECT]) -> Result<Self, PlateError> {
        let model = |parameters: &Parameters| {
            let (object, mu) = object_of(first, parameters);
            Replay::new(&object, mu)
        };
        let mut models = vec![model(&middle)?];
        for (index, step) in steps.into_iter().enumerate().filter(|(_, step)| *step > 0.0) {
            for side in [-step, step] {
                let mut parameters = middle;
                parameters[index] += side;
                models.push(model(&parameters)?);
            }
        }
        Ok(Self { middle, steps, models, past: VecDeque::new() })
    }

    pub(super) fn middle(&self) -> &Parameters {
        &self.middle
    }

    /// Distance from the middle in steps, of the parameter that is farthest away.
    pub(super) fn distance(&self, parameters: &Parameters) -> f64 {
        let of = |i: usize| {
            if self.steps[i] > 0.0 { ((parameters[i] - self.middle[i]) / self.steps[i]).abs() } else { 0.0 }
        };
        (0..OF_OBJECT).map(of).fold(0.0, f64::max)
    }

    /// Puts the object at rest at a pose where it has been long.
    pub(super) fn place(&mut self, [x, y, phi]: [f64; 3]) -> Result<(), PlateError> {
        self.past.clear();
        self.models.iter_mut().try_for_each(|model| model.set_state([x, y, phi, 0.0, 0.0, 0.0]))?;
        self.keep();
        Ok(())
    }

    fn keep(&mut self) {
        self.past.push_front(self.models.iter().map(Replay::state).collect());
        self.past.truncate(KEPT);
    }

    /// Whether the object rests whatever the parameters.
    pub(super) fn at_rest(&self) -> bool {
        self.models.iter().all(|model| model.state()[3..].iter().all(|v| *v == 0.0))
    }

    /// Moves on by a period of the plate's motion.
    pub(super) fn advance(&mut self, plate: &PlateKinematics, command: Command, period: f64) -> Result<(), PlateError> {
        self.models.iter_mut().try_for_each(|model| model.advance(plate, command, period))?;
        self.keep();
        Ok(())
    }

    /// The state `x, y, phi, vx, vy, w` now.
    pub(super) fn state(&self, parameters: &Parameters) -> [f64; 6] {
        self.evaluate(0, parameters).0
    }

    /// State so many samples ago with its derivatives with respect to the parameters of the object.
    fn evaluate(&self, ago: usize, parameters: &Parameters) -> ([f64; 6], [[f64; OF_OBJECT]; 6]) {
        let states = &self.past[ago.min(self.past.len() - 1)];
        let (mut state, mut slopes) = (states[0], [[0.0; OF_OBJECT]; 6]);
        let mut sides = states[1..].chunks_exact(2);
        for (index, step) in self.steps.into_iter().enumerate().filter(|(_, step)| *step > 0.0) {
            let Some([below, above]) = sides.next() else { break };
            let u = (parameters[index] - self.middle[index]) / step;
            let inner = u.clamp(-PARABOLA, PARABOLA);
            for i in 0..6 {
                let (half, bend) = (0.5 * (above[i] - below[i]), 0.5 * (above[i] + below[i]) - states[0][i]);
                let slope = half + 2.0 * bend * inner;
                state[i] += half * inner + bend * inner * inner + slope * (u - inner);
                slopes[i][index] = slope / step;
            }
        }
        (state, slopes)
    }

    /// What a camera with the latency of the parameters sees now.
    pub(super) fn seen(&self, parameters: &Parameters, period: f64) -> Seen {
        let samples = parameters[LATENCY] / period;
        let (ago, share) = (samples.floor() as usize, samples.fract());
        let (late, late_slopes) = self.evaluate(ago, parameters);
        let mut seen = Seen { pose: [late[0], late[1], late[2]], slopes: [[0.0; PARAMETERS]; 3] };
        let (early, early_slopes) = if share > 0.0 { self.evaluate(ago + 1, parameters) } else { (late, late_slopes) };
        for i in 0..3 {
            // The cubic with the positions and velocities of both samples.
            let (v, w) = (-period * late[i + 3], -period * early[i + 3]);
            let rise = early[i] - late[i];
            let (a, b) = (3.0 * rise - 2.0 * v - w, v + w - 2.0 * rise);
            if share > 0.0 {
                seen.pose[i] = late[i] + share * (v + share * (a + share * b));
            }
            for j in 0..OF_OBJECT {
                seen.slopes[i][j] = late_slopes[i][j] + share * (early_slopes[i][j] - late_slopes[i][j]);
            }
            seen.slopes[i][LATENCY] = -(late[i + 3] + share * (early[i + 3] - late[i + 3]));
        }
        seen
    }
}
