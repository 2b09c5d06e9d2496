//! Synthetic logs of a one-axis slider with an effect that its model lacks, and what counts as finding it.
//!
//! The plant `m v' = u − Fc Sgn(v) + (hidden effect)` is simulated with exact sticking and slipping; what is handed out as the log is
//! measured and noisy, and the model that belongs to it has the nominal equations with wrong parameters. The truth is kept apart.

mod error;
mod excitation;
mod hidden;
mod score;
mod slider;

pub use error::SyntheticError;
pub use excitation::Excitation;
pub use hidden::HiddenEffect;
pub use score::Score;
pub use slider::{Hidden, Slider, SliderLog, SliderSensors, SliderTruth};
