//! What is measured in a problem, and the estimator.

use crate::error::MpcError;
use crate::estimation::{EstimationProblem, Estimator, ExtendedKalman, MovingHorizon, MovingHorizonSettings};
use crate::ocp::VectorFunction;
use bracketry_system::System;

/// Which estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimatorKind {
    /// [`MovingHorizon`].
    MovingHorizon,
    /// [`ExtendedKalman`].
    ExtendedKalman,
}

/// What is measured in a problem, and what makes states of it.
#[derive(Clone)]
pub struct Estimation {
    /// Which estimator.
    pub kind: EstimatorKind,
    /// Sensors, noise, unknown parameters and disturbances.
    pub problem: EstimationProblem,
    /// Length of the horizon and number of programs per sample (moving horizon).
    pub settings: MovingHorizonSettings,
    /// Names of the measured outputs.
    pub names: Vec<String>,
}

impl Estimation {
    /// The estimator at time 0.
    ///
    /// # Errors
    /// If the estimation problem contradicts itself or the model.
    pub fn estimator(&self) -> Result<Box<dyn Estimator>, MpcError> {
        Ok(match self.kind {
            EstimatorKind::MovingHorizon => Box::new(MovingHorizon::new(&self.problem, self.settings)?),
            EstimatorKind::ExtendedKalman => Box::new(ExtendedKalman::new(&self.problem)?),
        })
    }

    /// What the sensors of a plant measure without noise, as a function of its state.
    ///
    /// # Errors
    /// If an output uses a name that the plant does not have.
    pub fn outputs(&self, plant: &System) -> Result<VectorFunction, MpcError> {
        let texts: Vec<&str> = self.problem.outputs.iter().map(|o| o.expression.as_str()).collect();
        VectorFunction::parse(plant, &[], &texts)
    }

    /// Whether anything but the state is estimated.
    pub(crate) fn hands_over(&self) -> bool {
        !self.problem.parameters.is_empty() || !self.problem.disturbances.is_empty()
    }
}
