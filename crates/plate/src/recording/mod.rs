//! Recordings of the simulated plant as a laboratory would make them, with a mismatch between plant and model.

mod actuated_motion;
mod error;
mod mismatch;
mod multisine;
mod random;
mod settings;
mod synthetic_log;

pub use error::RecordingError;
pub use mismatch::PlateMismatch;
pub use multisine::multisine;
pub use random::{Random, seed_of};
pub use settings::RecordingSettings;
pub use synthetic_log::{SyntheticLog, synthetic_log};
