//! What shooting needs of a method of integration.

use super::interval::Interval;
use super::stages::Stages;
use crate::dynamics::Dynamics;

/// A state, and what is wanted along an interval that it starts.
pub(crate) struct Differentiated<'a> {
    /// The state at the start, then at the end.
    pub(crate) x: &'a mut [f64],
    /// The derivative of the end state with respect to (x, u), n rows of n + m.
    pub(crate) jacobian: &'a mut [f64],
    /// The stages, noted where somebody wants them.
    pub(crate) stages: Option<&'a mut Stages>,
}

/// A one-step method for dynamics of n states and m inputs, with its working memory.
pub(crate) trait OneStepMethod: Send {
    /// Advances `x` over the interval. False where the equations of a step could not be solved; `x` is then no number.
    fn advance(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, x: &mut [f64]) -> bool;

    /// As [`OneStepMethod::advance`], with the derivative.
    fn differentiate(&mut self, dynamics: &mut dyn Dynamics, interval: Interval<'_>, to: Differentiated<'_>) -> bool;

    /// The adjoints of the field at the noted stages of steps of length `h`, from that of the end state, `lambda`, which
    /// becomes that of the start.
    fn adjoints(&mut self, h: f64, stages: &mut Stages, lambda: &mut [f64]);
}

/// Sets a matrix of `width` columns, stored by rows, to (I 0).
pub(super) fn set_identity(matrix: &mut [f64], width: usize) {
    matrix.fill(0.0);
    matrix.iter_mut().step_by(width + 1).for_each(|v| *v = 1.0);
}
