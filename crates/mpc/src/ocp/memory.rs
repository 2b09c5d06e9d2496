//! Inputs that are remembered for one interval: costs and constraints of their rates are functions of state and input then.

use super::bounds::Bounds;
use super::moves::Moves;
use super::previous_input::PreviousInput;
use super::problem::Ocp;
use crate::trajectory::PlannedTrajectory;

impl Ocp {
    /// Number of states of the dynamics.
    pub fn model_states(&self) -> usize {
        self.states() - self.previous_inputs.len()
    }

    /// Makes the value of an input over the interval before a state, which comes last.
    pub fn remember(&mut self, input: usize) {
        self.previous_inputs.push(PreviousInput { input, rate: (f64::NEG_INFINITY, f64::INFINITY) });
        self.state_bounds.push(Bounds::FREE);
        self.state_scale.push(1.0);
        self.state_trust.push(f64::INFINITY);
    }

    /// Where the constants stand in programs: inputs that are held over the whole horizon with the states that carry them on. From
    /// the second interval on, these states take their place, which is the same where the dynamics hold: so constants are
    /// parameters, whose curvature adds up along the horizon.
    pub(crate) fn carried(&self) -> Vec<(usize, usize)> {
        let first = self.model_states();
        let carrier = |j: &usize| self.previous_inputs.iter().position(|p| p.input == *j);
        self.constant_inputs.iter().filter_map(|j| Some((*j, first + carrier(j)?))).collect()
    }

    /// Which variables of the list (x, u) stand at the place of another one.
    pub(crate) fn moves(&self) -> Moves {
        let n = self.states();
        Moves {
            first: self.free_starts.iter().map(|&(state, j)| (state, n + j)).collect(),
            later: self.carried().into_iter().map(|(j, state)| (n + j, state)).collect(),
        }
    }

    /// Gives the first state of a trajectory the values of the inputs that stand for it.
    pub(crate) fn start_as_decided(&self, trajectory: &mut PlannedTrajectory) {
        for &(state, j) in &self.free_starts {
            trajectory.x_mut(0)[state] = trajectory.u(0)[j];
        }
    }

    /// Appends to a state of the dynamics what is remembered of the input `before`.
    pub fn append_previous(&self, x: &mut Vec<f64>, before: &[f64]) {
        x.extend(self.previous_inputs.iter().map(|p| before[p.input]));
    }

    /// States of the dynamics along a run, with the previous inputs; `before` is the input before the first of the inputs `u`.
    pub fn with_previous(&self, x: &[Vec<f64>], u: &[Vec<f64>], before: &[f64]) -> Vec<Vec<f64>> {
        let before = std::iter::once(before).chain(u.iter().map(Vec::as_slice));
        x.iter()
            .zip(before)
            .map(|(x, before)| {
                let mut x = x.clone();
                self.append_previous(&mut x, before);
                x
            })
            .collect()
    }
}
