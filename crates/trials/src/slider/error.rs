//! Synthetic logs that cannot be made.

use super::effect::SliderEffect;
use bracketry_sim::{InputError, Outcome, SimError};
use bracketry_system::FileError;

/// A synthetic log that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SyntheticError {
    /// A setting of the experiment without meaning.
    #[error("the setting {name} = {value} must be finite and not negative, and positive unless it is lead or noise")]
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// No strength gives the effect the wanted size in this experiment.
    #[error("{} reaches {reached} instead of {wanted} times the drive's rms: choose another size or excitation", .effect.name())]
    Size {
        /// The effect.
        effect: SliderEffect,
        /// The size wanted, relative to the drive's rms.
        wanted: f64,
        /// The size reached.
        reached: f64,
    },
    /// The simulation ended early.
    #[error("the slider's simulation ended early: {0:?}")]
    Ended(Outcome),
    /// The plant's equations.
    #[error(transparent)]
    Model(#[from] FileError),
    /// The plant's inputs.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The plant's simulation.
    #[error(transparent)]
    Simulation(#[from] SimError),
}
