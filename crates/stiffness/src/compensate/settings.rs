//! Settings of a compensation.

use super::filter::{FilterOrder, largest_excess};
use nalgebra::Vector3;

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
    /// Largest gain from wrench to correction over all frequencies: of filter and prediction, times `1 − s²`. Without a
    /// prediction 1 at most.
    pub fn largest_gain(&self) -> f64 {
        let believed = 1.0 - self.stiffness_error * self.stiffness_error;
        let predicted = self.lag.map_or(0.0, |lag| largest_excess(self.order, self.cutoff, self.period, lag));
        believed * (1.0 + predicted)
    }
}
