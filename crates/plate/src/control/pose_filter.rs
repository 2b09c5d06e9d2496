//! A filter for the offset of the object from its simulated motion and for the parameters of the simulations.

use super::learned::{PARAMETERS, Parameters, bounded};
use super::model_family::ModelFamily;
use nalgebra::{SMatrix, SVector};

/// Offset and parameters.
const STATES: usize = 3 + PARAMETERS;
pub(super) type Vector = SVector<f64, STATES>;
type Matrix = SMatrix<f64, STATES, STATES>;

/// Growth of the offset's standard deviation in the first second of motion (a random walk): m and rad.
pub(super) const DRIFT: [f64; 2] = [2e-3, 2e-2];
/// The same of the coefficient's logarithm.
const WANDER: f64 = 0.01;
/// Innovations beyond this many standard deviations are taken for a push or an outlier.
const GATE: f64 = 6.0;
/// Those beyond this many count as if their noise were as much larger (Huber 1964).
const ROBUST: f64 = 2.5;
/// Least standard deviation of a measurement: m and rad.
pub(super) const LEAST_NOISE: [f64; 2] = [1e-6, 1e-5];

/// Offset and parameters with their covariance.
#[derive(Debug, Clone)]
pub(super) struct Filter {
    pub(super) estimate: Vector,
    pub(super) covariance: Matrix,
    surprises: usize,
}

impl Filter {
    /// Everything is zero and known.
    pub(super) fn new() -> Self {
        Self { estimate: Vector::zeros(), covariance: Matrix::zeros(), surprises: 0 }
    }

    pub(super) fn parameters(&self) -> Parameters {
        std::array::from_fn(|i| self.estimate[3 + i])
    }

    /// Begins a run: the offset is that of its start.
    pub(super) fn begin(&mut self, variance: [f64; 3]) {
        self.surprises = 0;
        for (i, variance) in variance.into_iter().enumerate() {
            self.estimate[i] = 0.0;
            self.covariance.row_mut(i).fill(0.0);
            self.covariance.column_mut(i).fill(0.0);
            self.covariance[(i, i)] = variance;
        }
    }

    /// What a period of motion adds to the uncertainty.
    pub(super) fn drift(&mut self, period: f64) {
        for i in 0..3 {
            self.covariance[(i, i)] += DRIFT[i / 2].powi(2) * period;
        }
        if self.covariance[(3, 3)] > 0.0 {
            self.covariance[(3, 3)] += WANDER.powi(2) * period;
        }
    }

    /// Takes in a measured pose, but for one that does not fit at all.
    pub(super) fn take(&mut self, family: &ModelFamily, pose: &[f64; 3], noise: &[f64; 3], period: f64) {
        if pose.iter().any(|v| !v.is_finite()) {
            return;
        }
        let before = self.estimate;
        let seen = family.seen(&self.parameters(), period);
        let rows: [Vector; 3] = std::array::from_fn(|i| {
            let mut row = Vector::zeros();
            row[i] = 1.0;
            row.fixed_rows_mut::<PARAMETERS>(3).copy_from_slice(&seen.slopes[i]);
            row
        });
        let predicted: [f64; 3] = std::array::from_fn(|i| seen.pose[i] + before[i]);
        let variance = |filter: &Self, i: usize| rows[i].dot(&(filter.covariance * rows[i])) + noise[i].powi(2);
        let surprising = (0..3)
            .any(|i| (pose[i] - predicted[i]).abs() > GATE * variance(self, i).sqrt() + 20.0 * LEAST_NOISE[i / 2]);
        self.surprises = if surprising { self.surprises + 1 } else { 0 };
        if surprising {
            if self.surprises < 3 {
                return;
            }
            // Not an outlier: something has pushed the object, or the model is wrong.
            for i in 0..3 {
                self.covariance[(i, i)] += (10.0 * DRIFT[i / 2]).powi(2);
            }
        }
        for i in 0..3 {
            let row = rows[i];
            let innovation = pose[i] - predicted[i] - row.dot(&(self.estimate - before));
            let expected = variance(self, i);
            let excess = (innovation.abs() / (ROBUST * expected.sqrt())).max(1.0);
            let gain_of = self.covariance * row;
            let gain = gain_of / (expected * excess);
            self.estimate += gain * innovation;
            self.covariance -= gain * gain_of.transpose();
            self.covariance = 0.5 * (self.covariance + self.covariance.transpose());
        }
        let mut parameters = self.parameters();
        bounded(&mut parameters);
        self.estimate.fixed_rows_mut::<PARAMETERS>(3).copy_from_slice(&parameters);
    }
}
