//! The controller of a problem, stepped from outside.

mod changes;
mod controller;
mod log;

pub use changes::Change;
pub use controller::{LiveController, LiveStep};
pub use log::LoopLog;
