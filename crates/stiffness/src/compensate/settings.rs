//! Settings of a compensation, and what can be wrong with them.

use super::filter::FilterOrder;
use crate::error::StiffnessError;
use nalgebra::{Isometry3, Vector3};

/// A force sensor between the robot and what it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceSensor {
    /// Pose of its frame (origin of its moments, its axes) in the frame of the tool point.
    pub pose: Isometry3<f64>,
    /// Largest force it can measure (N); beyond it a reading is a fault.
    pub force_range: f64,
    /// Largest moment it can measure (N·m).
    pub moment_range: f64,
}

/// How a [`crate::Compensator`] works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompensationSettings {
    /// Time between two steps (s).
    pub period: f64,
    /// Cutoff of the filter of the process wrench (Hz).
    pub cutoff: f64,
    /// Order of that filter.
    pub order: FilterOrder,
    /// Newton steps where links bend. A robot that bends in its joints alone needs none.
    pub newton_steps: usize,
    /// Largest correction of a joint (rad, m).
    pub correction_limit: f64,
    /// Largest rate at which the correction of a joint changes (rad/s, m/s).
    pub rate_limit: f64,
    /// Acceleration of gravity in base axes (m/s²).
    pub gravity: Vector3<f64>,
}

impl Default for CompensationSettings {
    /// 4 ms, first order at 5 Hz, two Newton steps, at most 10 mrad and 50 mrad/s, gravity along −z.
    fn default() -> Self {
        Self {
            period: 0.004,
            cutoff: 5.0,
            order: FilterOrder::First,
            newton_steps: 2,
            correction_limit: 0.01,
            rate_limit: 0.05,
            gravity: Vector3::new(0.0, 0.0, -9.81),
        }
    }
}

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
    #[error("the eigenvalues of the loop through the process do not settle; check the matrices' units")]
    NoEigenvalues,
    /// Too little to fit.
    #[error("{found} samples; at least {needed} are needed to tell springs and lost motion apart")]
    TooFew {
        /// How many there are.
        found: usize,
        /// How many are needed.
        needed: usize,
    },
}

/// Refuses a number that is not positive and finite.
pub(super) fn positive(what: &'static str, value: f64) -> Result<(), CompensationError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(CompensationError::NotPositive { what, value }) }
}
