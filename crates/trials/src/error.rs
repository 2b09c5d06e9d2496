//! What can be wrong with a trial.

use bracketry_plate::PlateError;

/// What can be wrong with a trial or with a synthetic log.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrialError {
    /// The object, the plate or a controller.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// A range that is none.
    #[error("{name} = [{low}, {high}] must be finite numbers, in increasing order")]
    BadRange {
        /// Which one.
        name: &'static str,
        /// Its lower end.
        low: f64,
        /// Its upper end.
        high: f64,
    },
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
    /// A grid of places without places.
    #[error("the grid needs places y in increasing order and at least one yaw")]
    NoGrid,
    /// A computation was broken off through its progress callback.
    #[error("the computation was canceled")]
    Canceled,
    /// A file of trials cannot be read.
    #[error("the trials cannot be read: {0}")]
    File(Box<toml::de::Error>),
}
