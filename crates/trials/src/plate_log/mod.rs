//! Logs of the object on the plate as a laboratory would record them, with a mismatch between plant and model.

mod actuated_motion;
mod mismatch;
mod multisine;
mod recording;
mod synthetic_log;

pub use mismatch::PlateMismatch;
pub use multisine::multisine;
pub use recording::RecordingSettings;
pub use synthetic_log::{SyntheticLog, synthetic_log};
