//! What can be wrong with a trial.

use bracketry_plate::PlateError;

/// What can be wrong with a trial.
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
