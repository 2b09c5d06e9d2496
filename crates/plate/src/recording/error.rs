//! What can be wrong with a recording.

use crate::PlateError;

/// What can be wrong with a recording of the simulated plant.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RecordingError {
    /// The object, the plate, or the settings.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// A plate that would have to jump where the amplitude of an experiment changes.
    #[error("the plate would jump at {t} s, where the amplitude changes; choose a motion that starts and ends at rest")]
    Jump {
        /// When, in s.
        t: f64,
    },
    /// No multisine keeps the object where it should be.
    #[error("none of {tries} multisines keeps the object near its start; use a shorter duration or more friction")]
    NoMultisine {
        /// How many were tried.
        tries: u64,
    },
}
