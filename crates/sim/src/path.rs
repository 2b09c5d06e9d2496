//! The way of a simulation, recorded: its steps and events.

use crate::stepper::Stepper;
use crate::trajectory::interpolate;
use crate::{Mode, Switched};

/// A piece of a [`Path`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Piece {
    /// A step of length `h` with its middle at `t`; from `first` on: the state in the middle, the signs there.
    Step { t: f64, h: f64, first: usize, modes: usize },
    /// An event at which σ reaches zero at this rate; from `first` on: the jump of the field, and the gradient of σ.
    Jump { first: usize, rate: f64 },
}

/// The gradient of a switching function that reaches zero, its rate, and the field before its mode changes.
pub(crate) struct BeforeJump {
    gradient: Vec<f64>,
    rate: f64,
    field: Vec<f64>,
}

/// What a simulation leaves behind of its way: steps and events, see [`Stepper::follow`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Path {
    pub(crate) pieces: Vec<Piece>,
    pub(crate) numbers: Vec<f64>,
    pub(crate) modes: Vec<Mode>,
}

impl Path {
    /// Number of steps and events so far.
    pub fn len(&self) -> usize {
        self.pieces.len()
    }

    /// Whether nothing has been recorded.
    pub fn is_empty(&self) -> bool {
        self.pieces.is_empty()
    }

    fn clear(&mut self) {
        self.pieces.clear();
        self.numbers.clear();
        self.modes.clear();
    }
}

impl<S: Switched> Stepper<S> {
    /// Records the way from here on, in place of what `path` holds.
    pub fn follow(&mut self, mut path: Path) {
        path.clear();
        self.path = Some(path);
    }

    /// The number of pieces since [`Stepper::follow`].
    pub fn followed(&self) -> usize {
        self.path.as_ref().map_or(0, Path::len)
    }

    /// The way since [`Stepper::follow`], which ends.
    pub fn take_path(&mut self) -> Path {
        self.path.take().unwrap_or_default()
    }

    /// Records the attempted step of length `h`.
    pub(crate) fn record_step(&mut self, h: f64) {
        let Some(path) = &mut self.path else { return };
        interpolate(&self.coefficients, self.x.len(), 0.5, &mut self.stage);
        let (first, modes) = (path.numbers.len(), path.modes.len());
        path.pieces.push(Piece::Step { t: self.t + 0.5 * h, h, first, modes });
        path.numbers.extend_from_slice(&self.stage);
        path.numbers.extend(self.signs[0].iter().zip(&self.signs[6]).map(|(a, b)| 0.5 * (a + b)));
        path.modes.extend_from_slice(&self.modes);
    }

    /// What is known of the jump of the field before the modes change, where `switch` reaches zero now.
    pub(crate) fn before_jump(&self, switch: usize) -> Option<BeforeJump> {
        self.path.as_ref()?;
        let n = self.x.len();
        let part = self.multipliers.parts[switch].clone();
        let weight = |c: usize| if part.len() > 1 { self.signs[0][c] } else { 1.0 };
        let rate: f64 = part.clone().map(|c| weight(c) * self.multipliers.rate(c, &self.k[0])).sum();
        let gradient = (0..n)
            .map(|j| part.clone().map(|c| weight(c) * self.multipliers.gradient[c * n + j]).sum::<f64>())
            .collect();
        Some(BeforeJump { gradient, rate, field: self.k[0].clone() })
    }

    /// Records an event whose modes have been settled.
    pub(crate) fn record_jump(&mut self, before: Option<BeforeJump>) {
        let Some(BeforeJump { gradient, rate, field }) = before else { return };
        if !self.first_stage() {
            return;
        }
        let Some(path) = &mut self.path else { return };
        let first = path.numbers.len();
        path.pieces.push(Piece::Jump { first, rate });
        path.numbers.extend(self.k[0].iter().zip(&field).map(|(after, before)| after - before));
        path.numbers.extend(gradient);
    }
}
