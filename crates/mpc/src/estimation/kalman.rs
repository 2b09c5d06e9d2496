//! The extended Kalman filter.

use super::augmented::{Augmented, LinearizedInterval};
use super::estimate::{Estimate, EstimateStatus, Estimator};
use super::problem::{EstimationProblem, Outliers};
use crate::error::{MpcError, check_length};
use nalgebra::{DMatrix, DVector};

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
/// Source: Stengel 1994, ch. 4; parameters that are considered but not estimated: Schmidt 1966.
///
/// ```
/// use bracketry_mpc::estimation::{Estimator, EstimationProblem, ExtendedKalman, MeasuredOutput};
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
    room: Room,
}

/// Memory of the filter, used at every sample anew.
struct Room {
    step: LinearizedInterval,
    /// Noise that is not there.
    rest: Vec<f64>,
    /// F P.
    product: DMatrix<f64>,
    /// The estimate before the sample, and before its outputs.
    last: DVector<f64>,
    predicted: DVector<f64>,
    residual: Vec<f64>,
    frozen: Vec<bool>,
    absorb: AbsorbRoom,
}

impl Room {
    fn of(model: &Augmented) -> Self {
        let n = model.size();
        Self {
            step: LinearizedInterval::of(model),
            rest: vec![0.0; model.noise.len()],
            product: DMatrix::zeros(n, n),
            last: DVector::zeros(n),
            predicted: DVector::zeros(n),
            residual: vec![0.0; model.sensors.len()],
            frozen: vec![false; n],
            absorb: AbsorbRoom::of(n),
        }
    }
}

impl ExtendedKalman {
    /// A filter at time 0.
    ///
    /// # Errors
    /// If the problem contradicts itself or names something that the model does not have.
    pub fn new(problem: &EstimationProblem) -> Result<Self, MpcError> {
        let model = Augmented::new(problem)?;
        let (z, p, room) = (model.start.clone(), prior(&model), Room::of(&model));
        Ok(Self { model, outliers: problem.outliers, time: 0.0, dt: problem.dt, distrust: 0, z, p, room })
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

    /// Moves on by one interval without a measurement. What friction hides is kept for the outputs.
    pub(crate) fn predict(&mut self, u: &[f64]) {
        let Room { step, rest, product, last, frozen, .. } = &mut self.room;
        last.copy_from(&self.z);
        self.model.linearize(self.time, self.z.as_slice(), u, rest, self.distrust == 0, step);
        propagate(&mut self.p, &step.f, &step.g, product);
        self.z.copy_from(&step.end);
        self.time += self.dt;
        frozen.copy_from_slice(&step.hidden);
    }

    /// Takes in the outputs one by one; returns how many were lost.
    pub(crate) fn take_in(&mut self, y: &[f64]) -> usize {
        let Room { predicted, residual, frozen, absorb: room, .. } = &mut self.room;
        let n = self.z.len();
        self.model.measure(self.time, self.z.as_slice());
        let (h, c) = self.model.measured();
        predicted.copy_from(&self.z);
        let mut surprised = false;
        for (i, r) in residual.iter_mut().enumerate() {
            *r = self.model.residual(i, y[i], h[i]);
            let variance = room.spread(&self.p, &c[i * n..(i + 1) * n]) + self.model.sensors[i].0;
            surprised |= r.abs() > SURPRISE * variance.sqrt();
        }
        self.distrust = if surprised { DISTRUST } else { self.distrust.saturating_sub(1) };
        if surprised {
            frozen.fill(false);
        }
        let mut lost = 0;
        for i in 0..y.len() {
            if !y[i].is_finite() {
                lost += 1;
                continue;
            }
            let row = &c[i * n..(i + 1) * n];
            // The residual of the linearization at the prediction, moved along with the outputs before this one.
            let moved: f64 = (0..n).map(|j| row[j] * (self.z[j] - predicted[j])).sum();
            let output = ScalarOutput { row, residual: residual[i] - moved, noise: self.model.sensors[i].0 };
            absorb(&mut self.z, &mut self.p, &output, self.outliers, frozen, room);
        }
        for (v, b) in self.z.iter_mut().zip(&self.model.bounds) {
            *v = v.clamp(b.0, b.1);
        }
        lost
    }

    /// How the sample ended; where the numbers are not finite, the filter starts again.
    pub(crate) fn finish(&mut self, lost: usize) -> EstimateStatus {
        let finite = self.z.iter().chain(self.p.iter()).all(|v| v.is_finite());
        if !finite {
            self.z.copy_from(&self.room.last);
            self.p = prior(&self.model);
            EstimateStatus::Restarted
        } else if lost == self.model.sensors.len() {
            EstimateStatus::Predicted
        } else {
            EstimateStatus::Updated { lost }
        }
    }

    /// [`ExtendedKalman::take_in`] at the time of the current estimate, of which friction hides nothing.
    pub(crate) fn take_in_first(&mut self, y: &[f64]) -> EstimateStatus {
        self.room.last.copy_from(&self.z);
        self.room.frozen.fill(false);
        let lost = self.take_in(y);
        self.finish(lost)
    }
}

impl Estimator for ExtendedKalman {
    fn correct_into(&mut self, y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        check_length("the measurement", y.len(), self.model.sensors.len())?;
        let status = self.take_in_first(y);
        write_estimate(&self.model, &self.z, &self.p, status, estimate);
        Ok(())
    }

    fn update_into(&mut self, u: &[f64], y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        check_length("the measurement", y.len(), self.model.sensors.len())?;
        check_input(&self.model, u)?;
        self.predict(u);
        let lost = self.take_in(y);
        let status = self.finish(lost);
        write_estimate(&self.model, &self.z, &self.p, status, estimate);
        Ok(())
    }
}

/// P ← F P Fᵀ + G Gᵀ, with room for F P.
pub(crate) fn propagate(p: &mut DMatrix<f64>, f: &DMatrix<f64>, g: &DMatrix<f64>, product: &mut DMatrix<f64>) {
    let n = p.nrows();
    for j in 0..n {
        for i in 0..n {
            product[(i, j)] = (0..n).map(|k| f[(i, k)] * p[(k, j)]).sum();
        }
    }
    for j in 0..n {
        for i in 0..n {
            let moved: f64 = (0..n).map(|k| product[(i, k)] * f[(j, k)]).sum();
            let added: f64 = (0..g.ncols()).map(|k| g[(i, k)] * g[(j, k)]).sum();
            p[(i, j)] = moved + added;
        }
    }
}

/// A scalar output: ∂h/∂z, its residual, and the variance of its noise.
pub(crate) struct ScalarOutput<'a> {
    pub(crate) row: &'a [f64],
    pub(crate) residual: f64,
    pub(crate) noise: f64,
}

/// Room for [`absorb`]: P hᵀ and the gain.
pub(crate) struct AbsorbRoom {
    ph: Vec<f64>,
    gain: Vec<f64>,
}

impl AbsorbRoom {
    pub(crate) fn of(states: usize) -> Self {
        Self { ph: vec![0.0; states], gain: vec![0.0; states] }
    }

    /// h P hᵀ; keeps P hᵀ.
    fn spread(&mut self, p: &DMatrix<f64>, row: &[f64]) -> f64 {
        for (i, ph) in self.ph.iter_mut().enumerate() {
            *ph = row.iter().enumerate().map(|(j, h)| p[(i, j)] * h).sum();
        }
        row.iter().zip(&self.ph).map(|(h, ph)| h * ph).sum()
    }
}

/// Takes in one scalar output, without changing what is frozen.
pub(crate) fn absorb(
    z: &mut DVector<f64>,
    p: &mut DMatrix<f64>,
    output: &ScalarOutput<'_>,
    outliers: Outliers,
    frozen: &[bool],
    room: &mut AbsorbRoom,
) {
    let (r, mut noise) = (output.residual, output.noise);
    let spread = room.spread(p, output.row);
    if let Outliers::Huber(threshold) = outliers {
        // The weight that Huber's function gives to this residual, as a larger variance.
        let ratio = r.abs() / (threshold * (spread + noise).sqrt());
        noise += (ratio - 1.0).max(0.0) * (spread + noise);
    }
    let variance = spread + noise;
    let AbsorbRoom { ph, gain } = room;
    for ((g, ph), frozen) in gain.iter_mut().zip(ph.iter()).zip(frozen) {
        *g = if *frozen { 0.0 } else { ph / variance };
    }
    for i in 0..z.len() {
        z[i] += gain[i] * r;
        for j in 0..z.len() {
            p[(i, j)] += gain[i] * gain[j] * variance - gain[i] * ph[j] - ph[i] * gain[j];
        }
    }
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

/// Writes what is known after a sample.
pub(crate) fn write_estimate(
    model: &Augmented,
    z: &DVector<f64>,
    p: &DMatrix<f64>,
    status: EstimateStatus,
    estimate: &mut Estimate,
) {
    let z = z.as_slice();
    let (states, parameters) = (model.states, model.parameters);
    for (list, values) in [
        (&mut estimate.x, &z[..states]),
        (&mut estimate.parameters, &z[states..states + parameters]),
        (&mut estimate.disturbance, &z[states + parameters..]),
    ] {
        list.clear();
        list.extend_from_slice(values);
    }
    estimate.std.clear();
    estimate.std.extend((0..z.len()).map(|i| p[(i, i)].max(0.0).sqrt()));
    estimate.status = status;
}
