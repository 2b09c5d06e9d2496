//! Controllers that the predictive one is compared with.

mod halt;
mod two_step_controller;

pub use two_step_controller::TwoStepController;
