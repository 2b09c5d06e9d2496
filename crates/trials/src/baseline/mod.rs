//! Controllers that the predictive one is compared with.

mod averaged_controller;
mod cycle;
mod cycle_map;
mod halt;
mod two_step_controller;

pub use averaged_controller::AveragedController;
pub use cycle::Cycle;
pub use cycle_map::{CycleGrid, CycleMap};
pub use two_step_controller::TwoStepController;
