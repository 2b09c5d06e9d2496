//! Synthetic logs of a one-axis slider with an effect that its model lacks, and what counts as finding it.
//!
//! The plant `m v' = u − Fc Sgn(v) + (hidden effect)` is simulated with exact sticking and slipping; what is handed out as the log is
//! measured and noisy, and the model that belongs to it has the nominal equations with wrong parameters. The truth is kept apart.

mod effect;
mod error;
mod excitation;
mod experiment;
mod score;
mod trial;

pub use effect::SliderEffect;
pub use error::SyntheticError;
pub use excitation::Excitation;
pub use experiment::{Hidden, Slider, SliderLog, SliderSensors, SliderTruth};
pub use score::Score;
pub use trial::{Choice, SliderTrial};
