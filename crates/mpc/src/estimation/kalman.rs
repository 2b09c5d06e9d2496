//! The extended Kalman filter.

use super::augmented::Augmented;
use super::estimate::{Estimate, EstimateStatus, Estimator};
use super::problem::{EstimationProblem, Outliers};
use crate::error::{MpcError, check_length};
use nalgebra::{DMatrix, DVector, RowDVector};

/// Standard deviations of a residual beyond which "it sticks" is no longer believed.
const SURPRISE: f64 = 4.0;
/// Samples for which it is not believed after that.
const DISTRUST: usize = 10;

/// The discrete extended Kalman filter on the exact flow and its exact derivatives, with parameters and disturbances as
/// further states.
///
/// Outputs are taken in one at a time (their noise is independent), which needs no inverse, so that nearly exact ones do no
/// harm; the covariance follows Joseph's form. Dry friction is smoothed. While it sticks, the parameters and disturbances
/// that act against it are frozen: nothing can be learned of them, and the creep of smoothed friction would make them drift.
/// When the measurements contradict sticking, they are released.
///
/// Source: R. F. Stengel, Optimal Control and Estimation, ch. 4; parameters that are considered but not estimated: S. F.
/// Schmidt, Application of state-space methods to navigation problems, 1966.
///
/// ```
/// use bracketry_mpc::{Estimator, EstimationProblem, ExtendedKalman, MeasuredOutput};
/// use bracketry_system::System;
/// let mass = System::parse("mass.toml", r#"
///     states = ["x", "v"]
///     inputs = ["a"]
///     dynamics = { x = "v", v = "a" }
/// "#).unwrap();
/// let mut problem = EstimationProblem::new(&mass, 0.1, &[0.0, 0.0]);
/// problem.initial_std = vec![1.0, 1.0];
/// problem.outputs = vec![MeasuredOutput::new("x", 1e-3)];
/// let mut filter = ExtendedKalman::new(&problem).unwrap();
/// filter.correct(&[0.5]).unwrap();
/// let estimate = filter.update(&[0.0], &[0.7]).unwrap(); // 0.2 m in 0.1 s
/// assert!((estimate.x[1] - 2.0).abs() < 0.05);
/// ```
pub struct ExtendedKalman {
    pub(crate) model: Augmented,
    outliers: Outliers,
    time: f64,
    dt: f64,
    /// Samples for which friction is not believed to stick, whatever the model says.
    distrust: usize,
    pub(crate) z: DVector<f64>,
    pub(crate) p: DMatrix<f64>,
}

impl ExtendedKalman {
    /// A filter at time 0.
    ///
    /// # Errors
    /// If the problem contradicts itself or names something that the model does not have.
    pub fn new(problem: &EstimationProblem) -> Result<Self, MpcError> {
        let model = Augmented::new(problem)?;
        let z = model.start.clone();
        let p = prior(&model);
        Ok(Self { model, outliers: problem.outliers, time: 0.0, dt: problem.dt, distrust: 0, z, p })
    }

    /// Covariance of states, parameters and disturbances, one after the other.
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.p
    }

    /// Time of the estimate, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Whether sticking friction hides what acts against it, as far as is known at present.
    pub(crate) fn believes_sticking(&self) -> bool {
        self.distrust == 0
    }

    /// Moves on by one interval without a measurement; says what friction hides.
    pub(crate) fn predict(&mut self, u: &[f64]) -> Vec<bool> {
        let rest = vec![0.0; self.model.noise.len()];
        let step = self.model.interval(self.time, self.z.as_slice(), u, &rest, self.distrust == 0);
        self.p = &step.f * &self.p * step.f.transpose() + &step.g * step.g.transpose();
        self.z = step.end;
        self.time += self.dt;
        step.hidden
    }

    /// Takes in the outputs one by one; returns how many were lost.
    pub(crate) fn take_in(&mut self, y: &[f64], hidden: &[bool]) -> usize {
        let (h, c) = self.model.outputs(self.time, self.z.as_slice());
        let predicted = self.z.clone();
        let residual: Vec<f64> = (0..y.len()).map(|i| self.model.residual(i, y[i], h[i])).collect();
        let surprised = (0..y.len()).any(|i| {
            let row = c.row(i);
            let variance = (row * &self.p * row.transpose())[(0, 0)] + self.model.sensors[i].0;
            residual[i].abs() > SURPRISE * variance.sqrt()
        });
        self.distrust = if surprised { DISTRUST } else { self.distrust.saturating_sub(1) };
        let free = vec![false; hidden.len()];
        let frozen = if surprised { &free } else { hidden };
        let mut lost = 0;
        for i in 0..y.len() {
            if !y[i].is_finite() {
                lost += 1;
                continue;
            }
            let row = c.row(i).into_owned();
            // The residual of the linearization at the prediction, moved along with the outputs before this one.
            let r = residual[i] - (&row * (&self.z - &predicted))[(0, 0)];
            let noise = self.model.sensors[i].0;
            absorb(&mut self.z, &mut self.p, &row, r, noise, self.outliers, frozen);
        }
        for (v, b) in self.z.iter_mut().zip(&self.model.bounds) {
            *v = v.clamp(b.0, b.1);
        }
        lost
    }

    pub(crate) fn finish(&mut self, lost: usize, last: &DVector<f64>) -> Estimate {
        let finite = self.z.iter().chain(self.p.iter()).all(|v| v.is_finite());
        let status = if !finite {
            self.z.copy_from(last);
            self.p = prior(&self.model);
            EstimateStatus::Restarted
        } else if lost == self.model.sensors.len() {
            EstimateStatus::Predicted
        } else {
            EstimateStatus::Updated { lost }
        };
        estimate(&self.model, &self.z, &self.p, status)
    }
}

impl Estimator for ExtendedKalman {
    fn correct(&mut self, y: &[f64]) -> Result<Estimate, MpcError> {
        check_length("the measurement", y.len(), self.model.sensors.len())?;
        let last = self.z.clone();
        let lost = self.take_in(y, &vec![false; last.len()]);
        Ok(self.finish(lost, &last))
    }

    fn update(&mut self, u: &[f64], y: &[f64]) -> Result<Estimate, MpcError> {
        check_length("the measurement", y.len(), self.model.sensors.len())?;
        check_input(&self.model, u)?;
        let last = self.z.clone();
        let hidden = self.predict(u);
        let lost = self.take_in(y, &hidden);
        Ok(self.finish(lost, &last))
    }
}

/// Takes in one scalar output with the residual `r` and the row ∂h/∂z, without changing what is frozen.
pub(crate) fn absorb(
    z: &mut DVector<f64>,
    p: &mut DMatrix<f64>,
    row: &RowDVector<f64>,
    r: f64,
    mut noise: f64,
    outliers: Outliers,
    frozen: &[bool],
) {
    let ph = &*p * row.transpose();
    let spread = (row * &ph)[(0, 0)];
    if let Outliers::Huber(threshold) = outliers {
        // The weight that Huber's function gives to this residual, as a larger variance.
        let ratio = r.abs() / (threshold * (spread + noise).sqrt());
        noise += (ratio - 1.0).max(0.0) * (spread + noise);
    }
    let variance = spread + noise;
    let mut gain = &ph / variance;
    gain.iter_mut().zip(frozen).filter(|(_, f)| **f).for_each(|(g, _)| *g = 0.0);
    *z += &gain * r;
    let cross = &gain * ph.transpose();
    *p += &gain * gain.transpose() * variance - &cross - cross.transpose();
}

pub(crate) fn prior(model: &Augmented) -> DMatrix<f64> {
    DMatrix::from_diagonal(&model.start_std.map(|s| s * s))
}

pub(crate) fn check_input(model: &Augmented, u: &[f64]) -> Result<(), MpcError> {
    check_length("the input", u.len(), model.inputs)?;
    match u.iter().find(|v| !v.is_finite()) {
        Some(&value) => {
            Err(MpcError::Value { what: "the input".into(), value, remedy: "give the input that was applied" })
        }
        None => Ok(()),
    }
}

pub(crate) fn estimate(model: &Augmented, z: &DVector<f64>, p: &DMatrix<f64>, status: EstimateStatus) -> Estimate {
    let z = z.as_slice();
    let (states, parameters) = (model.states, model.parameters);
    Estimate {
        x: z[..states].to_vec(),
        parameters: z[states..states + parameters].to_vec(),
        disturbance: z[states + parameters..].to_vec(),
        std: p.diagonal().iter().map(|v| v.max(0.0).sqrt()).collect(),
        status,
    }
}
