//! Robots from files, with measurements and logs from tables: identification and compensation as reports.

mod compensation;
mod figures;
mod identification;
mod log;

use bracketry_stiffness::{CompensationError, IdentificationError};
use bracketry_system::FileError;

pub use compensation::{CompensatedLog, CompensatedRow, FaultCount};
pub use identification::{Identification, MethodSummary, ParameterSummary};
pub use log::RobotLog;

/// Why a run over a robot's data did not come about.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StiffnessRunError {
    /// A table that does not fit.
    #[error(transparent)]
    Table(#[from] FileError),
    /// The robot file lacks something.
    #[error("the robot file has no {what}: {remedy}")]
    Lacks {
        /// What is missing.
        what: &'static str,
        /// How to get it.
        remedy: &'static str,
    },
    /// Measurements that cannot be used, or tell nothing.
    #[error("{file}: {why}")]
    Identification {
        /// The table.
        file: String,
        /// What is wrong with them.
        why: IdentificationError,
    },
    /// A compensation that cannot work.
    #[error(transparent)]
    Compensation(#[from] CompensationError),
}
