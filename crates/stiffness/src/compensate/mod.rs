//! Compensation of the deformation while the robot works.

mod compensator;
mod filter;
mod settings;
mod stability;

pub use compensator::{Compensator, Correction, Fault, Status};
pub use filter::{FilterOrder, WrenchFilter};
pub use settings::{CompensationError, CompensationSettings, ForceSensor};
pub use stability::{Stability, stability};
