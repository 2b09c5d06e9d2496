//! Robot files: kinematics, springs, sensor, payload and compensation in TOML.

mod file;
mod joints;
mod rewrite;

pub use file::{NoiseLevels, RobotFile};
pub use rewrite::with_springs;
