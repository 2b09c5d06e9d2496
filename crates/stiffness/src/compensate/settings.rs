//! Settings of a compensation, and what can be wrong with them.

use super::filter::{FilterOrder, largest_excess};
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
    /// Lag of the servo from command to motion (s). Where it is given, the filtered wrench is predicted ahead by this and by the filter's own
    /// delay, as far as its slow changes go.
    pub lag: Option<f64>,
    /// Largest relative error s of the stiffnesses that is reckoned with, below 1: the correction is multiplied by `1 − s²`. A model
    /// `k̂ = (1 + e) k` with |e| ≤ s leaves `1 − (1 − s²)/(1 + e)` of the deformation, at worst s; in full it would leave s/(1 − s) where it is
    /// too soft.
    pub stiffness_error: f64,
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
    /// 4 ms, first order at 5 Hz, no prediction, the stiffnesses believed, two Newton steps, at most 10 mrad and 50 mrad/s, gravity along −z.
    fn default() -> Self {
        Self {
            period: 0.004,
            cutoff: 5.0,
            order: FilterOrder::First,
            lag: None,
            stiffness_error: 0.0,
            newton_steps: 2,
            correction_limit: 0.01,
            rate_limit: 0.05,
            gravity: Vector3::new(0.0, 0.0, -9.81),
        }
    }
}

impl CompensationSettings {
    /// Largest gain of the way from wrench to correction over all frequencies: of filter and prediction, times `1 − s²`. Without a
    /// prediction 1 at most.
    pub fn largest_gain(&self) -> f64 {
        let believed = 1.0 - self.stiffness_error * self.stiffness_error;
        let predicted = self.lag.map_or(0.0, |lag| largest_excess(self.order, self.cutoff, self.period, lag));
        believed * (1.0 + predicted)
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
    /// A lag that is none.
    #[error("the lag of the servo is {lag} s; it must be 0 or more")]
    Lag {
        /// Lag in s.
        lag: f64,
    },
    /// An error of stiffness that leaves nothing to compensate with.
    #[error(
        "the error of the stiffnesses to reckon with is {share}; it must be a share from 0 to below 1: 10 % is 0.1"
    )]
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
