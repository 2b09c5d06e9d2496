//! Compensation of the deformation while the robot works, and whether it is stable with the process.

mod compensator;
mod error;
mod filter;
mod settings;
mod stability;

pub use compensator::{Compensator, Correction, Fault, Status};
pub use error::CompensationError;
pub use filter::{FilterOrder, WrenchFilter};
pub use settings::CompensationSettings;
pub use stability::{Stability, stability};

pub(crate) use error::positive;
