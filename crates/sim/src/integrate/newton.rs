//! What the steps for stiff fields keep of each other: derivatives, factors, the motion so far.

use bracketry_numerics::dense::Lu;

/// What Newton's method keeps from one step to the next.
#[derive(Debug, Clone, Default)]
pub(crate) struct Newton {
    /// `∂f/∂x`, row by row, where it is known, and whether it is that of the present point.
    pub(super) jacobian: Option<Vec<f64>>,
    pub(super) current: bool,
    /// Whether it made the last iteration slow.
    pub(super) slow: bool,
    /// Its norm, with the states in units of their tolerances.
    pub(super) norm: f64,
    /// The length for which the factors of `μ/h − ∂f/∂x` for the real and the complex `μ` hold.
    pub(super) factored: Option<f64>,
    pub(super) real: Lu,
    pub(super) complex: Lu,
    /// Continuous extension of the step before and its length, if the motion goes on smoothly.
    pub(super) before: Vec<f64>,
    pub(super) before_length: Option<f64>,
    /// Whether the last attempt from the present point was rejected.
    pub(super) rejected: bool,
    /// Work since it was asked for, in evaluations of the field.
    pub(super) effort: f64,
}

impl Newton {
    /// The field jumps here, or the step is the first.
    pub(super) fn break_off(&mut self) {
        self.before_length = None;
        self.current = false;
        self.rejected = true;
    }

    /// Other modes have other derivatives.
    pub(crate) fn forget(&mut self) {
        self.jacobian = None;
        self.break_off();
    }

    /// Goes on from a step of length `h` with this continuous extension.
    pub(super) fn accept(&mut self, h: f64, coefficients: &[f64]) {
        self.before.clear();
        self.before.extend_from_slice(coefficients);
        self.before_length = Some(h);
        self.current = false;
        if self.slow {
            self.jacobian = None;
        }
        self.rejected = false;
    }

    /// The norm of the last Jacobian; infinite without one.
    pub(super) fn norm(&self) -> f64 {
        if self.jacobian.is_some() { self.norm } else { f64::INFINITY }
    }

    /// The work since the last call, in evaluations of the field.
    pub(super) fn take_effort(&mut self) -> f64 {
        std::mem::take(&mut self.effort)
    }

    /// Whether a further step of the same length is cheaper than one that is a little longer, because the factors hold for it.
    pub(crate) fn keeps_length(&self) -> bool {
        !self.slow && self.jacobian.is_some()
    }
}
