//! What answers measured states with inputs, sample by sample.

use super::step::{Step, StepLimits};
use crate::error::{MpcError, check_length};
use crate::estimation::Estimate;
use crate::ocp::Ocp;
use crate::trajectory::PlannedTrajectory;

/// Implements the named methods of `Controller` by those of the controller inside:
/// `forward_to!(self => self.controller; prepare, plan)`.
macro_rules! forward_to {
    ($this:ident => $inner:expr; $($method:ident),+ $(,)?) => {
        $( forward_to!(@ $method, $this, $inner); )+
    };
    (@ prepare, $this:ident, $inner:expr) => {
        fn prepare(&mut $this) -> Result<(), $crate::MpcError> {
            $inner.prepare()
        }
    };
    (@ feedback, $this:ident, $inner:expr) => {
        fn feedback(&mut $this, x: &[f64]) -> Result<&$crate::controller::Step, $crate::MpcError> {
            $inner.feedback(x)
        }
    };
    (@ shift, $this:ident, $inner:expr) => {
        fn shift(&mut $this) {
            $inner.shift();
        }
    };
    (@ skip, $this:ident, $inner:expr) => {
        fn skip(&mut $this) -> Result<(), $crate::MpcError> {
            $inner.skip()
        }
    };
    (@ estimate, $this:ident, $inner:expr) => {
        fn estimate(&$this) -> Option<&$crate::estimation::Estimate> {
            $inner.estimate()
        }
    };
    (@ plan, $this:ident, $inner:expr) => {
        fn plan(&$this) -> &$crate::PlannedTrajectory {
            $inner.plan()
        }
    };
    (@ ocp, $this:ident, $inner:expr) => {
        fn ocp(&$this) -> &$crate::Ocp {
            $inner.ocp()
        }
    };
    (@ change, $this:ident, $inner:expr) => {
        fn change(&mut $this, change: &mut dyn FnMut(&mut $crate::Ocp)) -> Result<(), $crate::MpcError> {
            $inner.change(change)
        }
    };
    (@ set_start, $this:ident, $inner:expr) => {
        fn set_start(&mut $this, k0: usize) {
            $inner.set_start(k0);
        }
    };
    (@ limit_next_step, $this:ident, $inner:expr) => {
        fn limit_next_step(&mut $this, limits: $crate::controller::StepLimits) {
            $inner.limit_next_step(limits);
        }
    };
    (@ relaxed_plan, $this:ident, $inner:expr) => {
        fn relaxed_plan(&$this) -> Option<&$crate::PlannedTrajectory> {
            $inner.relaxed_plan()
        }
    };
    (@ figures, $this:ident, $inner:expr) => {
        fn figures(&$this) -> $crate::controller::PlanErrors {
            $inner.figures()
        }
    };
    (@ set_parameters, $this:ident, $inner:expr) => {
        fn set_parameters(&mut $this, parameters: &[f64]) -> Result<(), $crate::MpcError> {
            $inner.set_parameters(parameters)
        }
    };
}

pub(crate) use forward_to;

/// What a controller tells of its samples so far, beyond its steps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanErrors {
    /// Largest violation of a bound or constraint that a plan predicts in any branch of a scenario tree, each in its own unit.
    pub predicted_violation: Option<f64>,
    /// Largest |∫ (relaxed − rounded) dt| of an input of a finite set, in its unit times seconds.
    pub rounding_error: Option<f64>,
}

/// Something that answers a measured state with an input, sample by sample.
///
/// A sample has three parts, in this order: [`prepare`](Controller::prepare) before the measurement,
/// [`feedback`](Controller::feedback) from the measurement to the input, [`shift`](Controller::shift) to the next sample.
pub trait Controller: Send {
    /// Everything that does not need the measurement. [`Controller::feedback`] does it where it has not been done.
    ///
    /// # Errors
    /// Only for misuse; trouble while solving is a status.
    fn prepare(&mut self) -> Result<(), MpcError> {
        Ok(())
    }
    /// The input for the next interval, from the state `x`, whose entries are NaN where nothing is known. The horizon stays
    /// where it is.
    ///
    /// # Errors
    /// Only for misuse; trouble while solving is a status.
    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError>;
    /// Moves the horizon to the next sample.
    fn shift(&mut self);
    /// Passes over a sample that was neither measured nor answered: the last input was held.
    ///
    /// # Errors
    /// Only for misuse.
    fn skip(&mut self) -> Result<(), MpcError> {
        self.shift();
        Ok(())
    }
    /// A whole sample: [`Controller::feedback`], then [`Controller::shift`].
    ///
    /// # Errors
    /// As [`Controller::feedback`].
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError> {
        let step = self.feedback(x)?.clone();
        self.shift();
        Ok(step)
    }
    /// What the last measurement told, where an [`Estimator`](crate::estimation::Estimator) stands in between.
    fn estimate(&self) -> Option<&Estimate> {
        None
    }
    /// The trajectory that the last input comes from; after [`Controller::shift`], the one that the next sample starts from.
    fn plan(&self) -> &PlannedTrajectory;
    /// The problem that the controller solves.
    fn ocp(&self) -> &Ocp;
    /// Changes references, bounds, values of targets or tabulated parameters of the problem, from the next preparation on. A
    /// change that contradicts the problem is refused and has no effect.
    ///
    /// # Errors
    /// What contradicts the problem.
    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError>;
    /// Sets the grid point of the run at which the next horizon starts (time and references follow it).
    fn set_start(&mut self, k0: usize);
    /// Limits the next step alone.
    fn limit_next_step(&mut self, limits: StepLimits);
    /// The first plan, where inputs of finite sets are rounded: the one before rounding.
    fn relaxed_plan(&self) -> Option<&PlannedTrajectory> {
        None
    }
    /// What it tells of its samples so far; nothing, unless it says so.
    fn figures(&self) -> PlanErrors {
        PlanErrors::default()
    }
    /// Gives the live parameters of the model these values. A controller has none unless it says so.
    ///
    /// # Errors
    /// If their number is not that of the live parameters.
    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        check_length("the parameters", parameters.len(), 0)
    }
}

impl<C: Controller + ?Sized> Controller for Box<C> {
    forward_to!(self => (**self);
        prepare, feedback, shift, skip, estimate, plan, ocp, change, set_start, limit_next_step, relaxed_plan, figures, set_parameters);
}
