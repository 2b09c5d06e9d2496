//! A milled circle, simulated: a process that the compensation is tried on.

mod circle;
mod cutting;
mod cutting_robot;

pub use circle::{CircleRun, CircleSample, MillingCircle, PathError};
pub use cutting::Cutting;
