//! A control system compiled for simulation, and what drives its inputs.

mod compiled;
mod drive;
mod impulses;
mod inputs;
mod switch_expressions;

pub use compiled::Model;
pub use inputs::{Hold, InputError, Inputs, Samples};

pub(crate) use drive::TIME;
