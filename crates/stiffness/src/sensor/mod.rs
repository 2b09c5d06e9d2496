//! The force sensor, what it carries, and how that is weighed.

mod force_sensor;
mod payload;
mod weighing;

pub use force_sensor::ForceSensor;
pub use payload::Payload;
pub use weighing::{PayloadError, PayloadEstimate, StaticReading, identify_payload};
