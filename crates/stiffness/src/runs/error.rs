//! Why a run over a robot's data did not come about.

use crate::compensate::CompensationError;
use crate::identify::IdentificationError;
use crate::sensor::PayloadError;
use bracketry_files::FileError;

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
    /// Readings at rest that do not determine what the sensor carries.
    #[error("{file}: {why}")]
    Weighing {
        /// The table.
        file: String,
        /// What is wrong with them.
        why: PayloadError,
    },
    /// Readings of force in other units.
    #[error(
        "the median reading of the sensor is {found:.3} N, but bias and weight of [payload] alone are {expected:.1} N; are units off by 1000 (kN \
         for N)? (remove [payload] if the readings are free of it)"
    )]
    Readings {
        /// Median of the readings (N).
        found: f64,
        /// Median of bias and weight (N).
        expected: f64,
    },
    /// Samples too rare for the filter.
    #[error(
        "a period of {period} s is too long for a cutoff of {cutoff} Hz; t is in seconds: divide it by 1000 if it is in ms, else \
         lower `cutoff` in [compensation] below {:.3} Hz", 0.5 / period
    )]
    Period {
        /// Period of the log (s).
        period: f64,
        /// Cutoff of the filter (Hz).
        cutoff: f64,
    },
    /// A compensation that cannot work.
    #[error(transparent)]
    Compensation(#[from] CompensationError),
}
