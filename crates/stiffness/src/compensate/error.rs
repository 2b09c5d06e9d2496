//! What can be wrong with a compensation.

use crate::error::StiffnessError;

/// Why there is no compensation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompensationError {
    /// Robot, springs, payload or a pose that do not fit.
    #[error(transparent)]
    Stiffness(#[from] StiffnessError),
    /// A cutoff that the sampling cannot represent.
    #[error(
        "a cutoff of {cutoff} Hz with a period of {period} s; it must lie between 0 and half the sampling rate, \
         {:.3} Hz", 0.5 / period
    )]
    Cutoff {
        /// Cutoff in Hz.
        cutoff: f64,
        /// Period in s.
        period: f64,
    },
    /// A lag that is none.
    #[error("the lag of the servo is {lag} s; it must be 0 or more")]
    Lag {
        /// Lag in s.
        lag: f64,
    },
    /// An error of stiffness that leaves nothing to compensate with.
    #[error("the assumed stiffness error is {share}; it must be a fraction from 0 to below 1: 10 % is 0.1")]
    StiffnessError {
        /// The share.
        share: f64,
    },
    /// A setting that must be positive.
    #[error("{what} is {value}; it must be positive")]
    NotPositive {
        /// Which one.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A simulation whose process pulls the tool in.
    #[error("the cutting force finds no depth at {angle:.3} rad of the circle: the process is stiffer than the robot")]
    NoDepth {
        /// Angle along the circle.
        angle: f64,
    },
    /// A matrix whose eigenvalues do not settle.
    #[error("the eigenvalues of the loop through the process do not converge; check the matrices' units")]
    NoEigenvalues,
    /// Too little to fit.
    #[error("{found} samples; at least {needed} are needed to separate springs and lost motion")]
    TooFew {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
}

/// Refuses a number that is not positive and finite.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<(), CompensationError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(CompensationError::NotPositive { what, value }) }
}
