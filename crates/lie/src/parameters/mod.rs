//! Verdicts as functions of parameters.

pub(crate) mod aspect;
pub(crate) mod cases;
pub(crate) mod confirm;
mod decompose;
mod explore;
mod factor;
mod limits;
pub(crate) mod map;
pub(crate) mod report;
mod state_values;
