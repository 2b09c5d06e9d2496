//! The course of a simulation, recorded: its steps and events.

use crate::friction::{Field, FrictionMode};
use crate::integrate::Step;

/// A piece of a [`Path`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Piece {
    /// A step of length `h` with its middle at `t`; from `first` on: the state in the middle, the signs there.
    Step { t: f64, h: f64, first: usize, modes: usize },
    /// An event at which σ reaches zero at this rate; from `first` on: the jump of the field, and the gradient of σ.
    Jump { first: usize, rate: f64 },
}

/// The steps and events of a simulation, see [`crate::Stepper::follow`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Path {
    pub(crate) pieces: Vec<Piece>,
    pub(crate) numbers: Vec<f64>,
    pub(crate) modes: Vec<FrictionMode>,
}

/// The gradient of a switching function that reaches zero, its rate, and the field before its mode changes.
pub(crate) struct FieldBefore {
    gradient: Vec<f64>,
    rate: f64,
    field: Vec<f64>,
}

impl FieldBefore {
    /// Where `switch` reaches zero at the start of a step, by the gradients of the last point.
    pub(crate) fn new(field: &Field<'_>, step: &Step, switch: usize) -> Self {
        let surfaces = &field.surfaces;
        let part = surfaces.parts[switch].clone();
        let weight = |c: usize| if part.len() > 1 { step.signs[0][c] } else { 1.0 };
        let entry = |j: usize| part.clone().map(|c| weight(c) * surfaces.gradient(c)[j]).sum();
        Self {
            gradient: (0..step.x.len()).map(entry).collect(),
            rate: part.clone().map(|c| weight(c) * surfaces.rate(c, &step.k[0])).sum(),
            field: step.k[0].clone(),
        }
    }
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

    pub(crate) fn clear(&mut self) {
        self.pieces.clear();
        self.numbers.clear();
        self.modes.clear();
    }

    /// Records the attempted step of length `h`.
    pub(crate) fn push_step(&mut self, step: &Step, h: f64, modes: &[FrictionMode]) {
        let (first, n) = (self.numbers.len(), step.x.len());
        self.pieces.push(Piece::Step { t: step.t + 0.5 * h, h, first, modes: self.modes.len() });
        self.numbers.resize(first + n, 0.0);
        step.interpolate(0.5, &mut self.numbers[first..]);
        self.numbers.extend(step.signs[0].iter().zip(&step.signs[6]).map(|(a, b)| 0.5 * (a + b)));
        self.modes.extend_from_slice(modes);
    }

    /// Records an event after which the field is `field`.
    pub(crate) fn push_jump(&mut self, before: &FieldBefore, field: &[f64]) {
        self.pieces.push(Piece::Jump { first: self.numbers.len(), rate: before.rate });
        self.numbers.extend(field.iter().zip(&before.field).map(|(after, before)| after - before));
        self.numbers.extend_from_slice(&before.gradient);
    }
}
