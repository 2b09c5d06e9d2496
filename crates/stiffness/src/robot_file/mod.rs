//! Robot files: kinematics, springs, sensor, payload and compensation in TOML.

mod document;
mod file;
mod joints;
mod rewrite;

pub use document::RobotFileError;
pub use file::{NoiseLevels, RobotFile};
pub use rewrite::with_springs;
