//! What an estimator does and says.

use crate::error::MpcError;

/// How an estimate came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimateStatus {
    /// From the measurements of this sample.
    Updated {
        /// Outputs that were lost and left out.
        lost: usize,
    },
    /// Every output was lost: the model's prediction.
    Predicted,
    /// The optimizer gave no usable answer: the update of the extended Kalman filter instead.
    Fallback,
    /// The numbers left the finite range; the estimator went back to its prior knowledge, at the last finite estimate.
    Restarted,
}

/// What is known after a sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The states of the model.
    pub x: Vec<f64>,
    /// The estimated parameters, in the order of [`EstimationProblem::parameters`](crate::estimation::EstimationProblem).
    pub parameters: Vec<f64>,
    /// The disturbances, in the order of [`EstimationProblem::disturbances`](crate::estimation::EstimationProblem).
    pub disturbance: Vec<f64>,
    /// Standard deviations of states, parameters and disturbances, one after the other, as the linearization gives them.
    pub std: Vec<f64>,
    /// How it came about.
    pub status: EstimateStatus,
}

impl Estimate {
    /// What stands before the first measurement.
    pub(crate) fn nothing() -> Self {
        let none = Vec::new;
        Self { x: none(), parameters: none(), disturbance: none(), std: none(), status: EstimateStatus::Predicted }
    }
}

/// An observer that runs beside a controller.
pub trait Estimator: Send {
    /// Takes in a measurement at the time of the current estimate (the first one of a run). Outputs that are not a number
    /// are left out. The estimate takes the place of the one before, whose memory it may use.
    ///
    /// # Errors
    /// If the number of outputs is wrong.
    fn correct_into(&mut self, y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError>;

    /// Goes on by one sampling period over which the input `u` was held, then takes in the measurement `y` at its end.
    /// Outputs that are not a number are left out. The estimate takes the place of the one before, whose memory it may use.
    ///
    /// # Errors
    /// If a length is wrong or an input is not finite; all that measurements can do is a status.
    fn update_into(&mut self, u: &[f64], y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError>;

    /// [`Estimator::correct_into`] in memory of its own.
    ///
    /// # Errors
    /// As [`Estimator::correct_into`].
    fn correct(&mut self, y: &[f64]) -> Result<Estimate, MpcError> {
        let mut estimate = Estimate::nothing();
        self.correct_into(y, &mut estimate).map(|()| estimate)
    }

    /// [`Estimator::update_into`] in memory of its own.
    ///
    /// # Errors
    /// As [`Estimator::update_into`].
    fn update(&mut self, u: &[f64], y: &[f64]) -> Result<Estimate, MpcError> {
        let mut estimate = Estimate::nothing();
        self.update_into(u, y, &mut estimate).map(|()| estimate)
    }
}

impl<E: Estimator + ?Sized> Estimator for Box<E> {
    fn correct_into(&mut self, y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        (**self).correct_into(y, estimate)
    }
    fn update_into(&mut self, u: &[f64], y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        (**self).update_into(u, y, estimate)
    }
}
