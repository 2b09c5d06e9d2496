//! What keeps a run from being started.

use bracketry_files::FileError;

use super::setup::PlateModel;
use crate::PlateError;

/// A run that could not start.
#[derive(Debug, thiserror::Error)]
pub enum PlateRunError {
    /// The object, the friction or the model.
    #[error(transparent)]
    Plate(#[from] PlateError),
    /// The log.
    #[error(transparent)]
    File(#[from] FileError),
    /// The inputs.
    #[error(transparent)]
    Input(#[from] bracketry_sim::InputError),
    /// The simulation was misused.
    #[error(transparent)]
    Sim(#[from] bracketry_sim::SimError),
    /// A law of friction that the model does not have.
    #[error("the model `{}` supports Coulomb friction only; omit --friction, or use --model area", model.name())]
    CoulombOnly {
        /// The model.
        model: PlateModel,
    },
    /// An object that does not press evenly, on a model that does not know such objects.
    #[error(
        "the model `{}` supports only objects that press with their whole footprint about their center of mass; omit --bearing and \
         --center-of-mass, or use --model area", model.name()
    )]
    EvenBearingOnly {
        /// The model.
        model: PlateModel,
    },
    /// The log does not cover the time.
    #[error(
        "the log `{log}` has the plate's motion from {from} s to {to} s, but the run needs it until {until} s; shorten --seconds"
    )]
    LogTooShort {
        /// The log.
        log: String,
        /// Its first time.
        from: f64,
        /// Its last time.
        to: f64,
        /// The end of the run.
        until: f64,
    },
    /// The log has no row within the run.
    #[error("{log}: the log has no time in common with the run; shift its column t or give --seconds")]
    NoCommonTime {
        /// The log.
        log: String,
    },
}
