//! Where the amplitude of an experiment follows the error.

use serde::Serialize;

/// The start of a period, where the amplitude follows the error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodStart {
    /// When, in s.
    pub t: f64,
    /// The error `e = q − q_desired` of the run (m, rad).
    pub error: f64,
    /// The amplitude that the error asks for.
    pub natural: f64,
    /// The amplitude that was held.
    pub held: f64,
    /// Where its sign comes from.
    pub sign: SignSource,
}

/// Where the sign of an amplitude comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SignSource {
    /// The error of the run.
    Run,
    /// The motion of the plate in the log over the period.
    LoggedPlate,
    /// The error of the log.
    LoggedError,
    /// The motion of the object in the log over the period, which is nearer to the run with this sign than to that with the other.
    LoggedMotion,
}
