//! What answers measured states with inputs, sample by sample.

use super::step::{Step, StepLimits};
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;

/// Something that answers a measured state with an input, sample by sample.
pub trait Controller {
    /// The input for the next interval, from the state `x`, whose entries are NaN where nothing is known.
    ///
    /// # Errors
    /// Only for misuse; trouble while solving is a status.
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError>;
    /// The problem that the controller solves.
    fn ocp(&self) -> &Ocp;
    /// Sets the grid point of the run at which the next horizon starts (time and references follow it).
    fn set_start(&mut self, k0: usize);
    /// Limits the next step alone.
    fn limit_next_step(&mut self, limits: StepLimits);
    /// Gives the live parameters of the model these values. A controller has none unless it says so.
    ///
    /// # Errors
    /// If their number is not that of the live parameters.
    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        check_length("the parameters", parameters.len(), 0)
    }
}

impl<C: Controller + ?Sized> Controller for Box<C> {
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError> {
        (**self).step(x)
    }
    fn ocp(&self) -> &Ocp {
        (**self).ocp()
    }
    fn set_start(&mut self, k0: usize) {
        (**self).set_start(k0);
    }
    fn limit_next_step(&mut self, limits: StepLimits) {
        (**self).limit_next_step(limits);
    }
    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        (**self).set_parameters(parameters)
    }
}
