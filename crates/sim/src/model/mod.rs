//! A control system compiled for simulation, and what drives its inputs.

mod compiled;
mod drive;
mod driving;
mod impulses;
mod inputs;
mod switch_expressions;
mod tapes;

pub use compiled::Model;
pub use inputs::{Hold, InputError, Inputs, Samples};

pub(crate) use drive::TIME;
