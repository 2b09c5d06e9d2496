//! The states of a simulation at any time, and its modes.

use crate::friction::{FrictionMode, ModeChange, ModeInterval};
use crate::integrate::{Step, interpolate, node_weights};

/// One step's continuous extension.
#[derive(Debug, Clone)]
struct Piece {
    t: f64,
    h: f64,
    /// Where its directions start, if they are kept.
    directions: Option<usize>,
}

/// States at any time of a simulation, with the changes of mode.
#[derive(Debug, Clone)]
pub struct Trajectory {
    dim: usize,
    start: f64,
    end: f64,
    initial_state: Vec<f64>,
    final_state: Vec<f64>,
    initial_modes: Vec<FrictionMode>,
    pieces: Vec<Piece>,
    /// Five coefficient vectors per piece.
    coefficients: Vec<f64>,
    /// Signs and directions at the nodes of implicit steps, where they cannot be told from the states.
    directions: Vec<f64>,
    changes: Vec<ModeChange>,
}

impl Trajectory {
    pub(crate) fn new(t: f64, x: &[f64], modes: &[FrictionMode]) -> Self {
        Self {
            dim: x.len(),
            start: t,
            end: t,
            initial_state: x.to_vec(),
            final_state: x.to_vec(),
            initial_modes: modes.to_vec(),
            pieces: Vec::new(),
            coefficients: Vec::new(),
            directions: Vec::new(),
            changes: Vec::new(),
        }
    }

    /// States that jump at these times, at least one, and hold in between: those of a model that is discrete in time.
    pub(crate) fn held(times: &[f64], states: &[Vec<f64>]) -> Self {
        let mut held = Self::new(times[0], &states[0], &[]);
        for (between, x) in times.windows(2).zip(states) {
            held.pieces.push(Piece { t: between[0], h: between[1] - between[0], directions: None });
            held.coefficients.extend_from_slice(x);
            held.coefficients.resize(5 * held.dim * held.pieces.len(), 0.0);
        }
        held.finish(times[times.len() - 1], &states[states.len() - 1]);
        held
    }

    /// Appends the attempted step of length `h`.
    pub(crate) fn push(&mut self, step: &Step, h: f64) {
        let nodes = step.implicit_signs();
        let directions = nodes.is_some().then_some(self.directions.len());
        self.pieces.push(Piece { t: step.t, h, directions });
        nodes.into_iter().flatten().for_each(|node| self.directions.extend_from_slice(node));
        self.coefficients.extend_from_slice(&step.coefficients);
        self.end = step.t + h;
        self.final_state.copy_from_slice(&step.end);
    }

    /// The `k` signs and directions at `t`, interpolated but not of unit length; none where they are not kept.
    pub(crate) fn directions(&self, t: f64, k: usize) -> Option<Vec<f64>> {
        let piece = &self.pieces[self.pieces.partition_point(|piece| piece.t <= t).checked_sub(1)?];
        let weights = node_weights(((t - piece.t) / piece.h).min(1.0));
        let mut s = vec![0.0; k];
        for (weight, node) in weights.iter().zip(self.directions[piece.directions?..].chunks(k)) {
            s.iter_mut().zip(node).for_each(|(s, v)| *s += weight * v);
        }
        Some(s)
    }

    /// The time and state at which the integrator stands, with what sticks projected.
    pub(crate) fn finish(&mut self, t: f64, x: &[f64]) {
        self.end = t;
        self.final_state.copy_from_slice(x);
    }

    /// What differs between the modes before and after an instant.
    pub(crate) fn push_mode_changes(&mut self, t: f64, before: &[FrictionMode], after: &[FrictionMode]) {
        let both = before.iter().zip(after).enumerate().filter(|(_, (from, to))| from != to);
        self.changes.extend(both.map(|(switch, (&from, &to))| ModeChange { t, switch, from, to }));
    }

    /// A smooth motion that begins at `t` in the state `x`, to be recorded by [`Trajectory::push_cubic`].
    pub fn starting_at(t: f64, x: &[f64]) -> Self {
        Self::new(t, x, &[])
    }

    /// Appends a piece from `t`, where the last one ends, to `t + h` (s), between two states with their time derivatives, by
    /// Hermite's cubic. A jump of the state belongs to the piece after it. All slices have the length of the state.
    pub fn push_cubic(&mut self, t: f64, h: f64, [x0, x1]: [&[f64]; 2], [dx0, dx1]: [&[f64]; 2]) {
        self.pieces.push(Piece { t, h, directions: None });
        let moved = |i: usize| x1[i] - x0[i];
        let bent = |i: usize| h * dx0[i] - moved(i);
        let coefficients = &mut self.coefficients;
        coefficients.extend_from_slice(x0);
        coefficients.extend((0..self.dim).map(moved));
        coefficients.extend((0..self.dim).map(bent));
        coefficients.extend((0..self.dim).map(|i| moved(i) - h * dx1[i] - bent(i)));
        coefficients.extend((0..self.dim).map(|_| 0.0));
        self.finish(t + h, x1);
    }

    /// The modes of all switches at the start.
    pub fn initial_modes(&self) -> &[FrictionMode] {
        &self.initial_modes
    }

    /// Number of states.
    pub fn dim(&self) -> usize {
        self.dim
    }

    /// First time, in seconds.
    pub fn start(&self) -> f64 {
        self.start
    }

    /// Last time, in seconds.
    pub fn end(&self) -> f64 {
        self.end
    }

    /// State at the last time.
    pub fn final_state(&self) -> &[f64] {
        &self.final_state
    }

    /// Writes the state at `t` into `x`; times outside the simulated span give the first or the last state.
    pub fn sample_into(&self, t: f64, x: &mut [f64]) {
        if t >= self.end {
            x.copy_from_slice(&self.final_state);
            return;
        }
        let index = self.pieces.partition_point(|piece| piece.t <= t);
        if index == 0 {
            x.copy_from_slice(&self.initial_state);
            return;
        }
        let piece = &self.pieces[index - 1];
        let width = 5 * self.dim;
        let coefficients = &self.coefficients[(index - 1) * width..index * width];
        interpolate(coefficients, self.dim, ((t - piece.t) / piece.h).min(1.0), x);
    }

    /// The state at `t`; see [`Trajectory::sample_into`].
    pub fn sample(&self, t: f64) -> Vec<f64> {
        let mut x = vec![0.0; self.dim];
        self.sample_into(t, &mut x);
        x
    }

    /// The times at which steps start, and the end.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        self.pieces.iter().map(|piece| piece.t).chain(std::iter::once(self.end))
    }

    /// The changes of mode, in order of time.
    pub fn mode_changes(&self) -> &[ModeChange] {
        &self.changes
    }

    /// The mode of switch `switch` at `t` (after the change, at a change).
    pub fn mode(&self, switch: usize, t: f64) -> Option<FrictionMode> {
        let before = self.changes.iter().filter(|change| change.switch == switch).take_while(|change| change.t <= t);
        Some(before.last().map_or(*self.initial_modes.get(switch)?, |change| change.to))
    }

    /// The modes of switch `switch` in time; empty if there is no such switch.
    pub fn mode_intervals(&self, switch: usize) -> Vec<ModeInterval> {
        let Some(&first) = self.initial_modes.get(switch) else {
            return Vec::new();
        };
        let mut intervals = Vec::new();
        let (mut from, mut mode) = (self.start, first);
        for change in self.changes.iter().filter(|e| e.switch == switch) {
            if change.t > from {
                intervals.push(ModeInterval { from, to: change.t, mode });
            }
            (from, mode) = (change.t, change.to);
        }
        intervals.push(ModeInterval { from, to: self.end, mode });
        intervals
    }

    /// Joins a later trajectory that starts where this one ends; its mode changes follow.
    pub fn append(&mut self, later: &Trajectory) {
        let shift = self.directions.len();
        let shifted = |piece: &Piece| Piece { directions: piece.directions.map(|d| d + shift), ..*piece };
        self.pieces.extend(later.pieces.iter().map(shifted));
        self.directions.extend_from_slice(&later.directions);
        self.coefficients.extend_from_slice(&later.coefficients);
        self.changes.extend_from_slice(&later.changes);
        self.end = later.end;
        self.final_state.copy_from_slice(&later.final_state);
    }
}
