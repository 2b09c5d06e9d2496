//! Verdicts as functions of parameters.

pub(crate) mod aspect;
pub(crate) mod cases;
pub(crate) mod confirm;
mod decompose;
mod explore;
mod factor;
mod limits;
pub(crate) mod map;
mod state_values;
