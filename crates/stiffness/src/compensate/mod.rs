//! Compensation of the deformation while the robot works, and what it gains on a milled circle.

mod circle;
mod compensator;
mod cutting;
mod filter;
mod lost_motion;
mod settings;
mod stability;

pub use circle::{CircleRun, CircleSample, MillingCircle, PathError};
pub use compensator::{Compensator, Correction, Fault, Status};
pub use cutting::Cutting;
pub use filter::{FilterOrder, WrenchFilter};
pub use lost_motion::{LostMotion, LostMotionReport, ResidualSample, explain_residual};
pub use settings::{CompensationError, CompensationSettings, ForceSensor};
pub use stability::{Stability, stability};
