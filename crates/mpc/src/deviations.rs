//! How far noise takes the state from its prediction.

use crate::dynamics::Dynamics;
use crate::error::MpcError;
use crate::integrator::Interval;
use crate::ocp::{CostPoint, Ocp};
use crate::riccati::dare;
use crate::transcription::Shooter;
use nalgebra::DMatrix;

/// Covariances of the deviation d of the state from its prediction, linearized at a point:
///
/// ```text
/// d⁺ = (A − B K) d + w,   Σ_{k+1} = (A − B K) Σ_k (A − B K)ᵀ + W,   Σ_0 = 0
/// ```
///
/// with the gain K of the infinite horizon of the stage cost at this point: at the samples to come, the controller will answer what it
/// measures.
#[derive(Clone, Debug)]
pub(crate) struct Deviations {
    /// Σ_0 … Σ_N, n rows of n, previous inputs included.
    pub(crate) covariances: Vec<DMatrix<f64>>,
    /// K, m rows of n; zero where the infinite horizon has no solution.
    pub(crate) gain: DMatrix<f64>,
    /// Whether it has one.
    pub(crate) feedback: bool,
}

impl Ocp {
    /// The deviations for noise of the standard deviation `noise` of every state of the dynamics per square root of a second, at
    /// the state `x` (previous inputs included) under the input `u`.
    ///
    /// # Errors
    /// If the linearization is not finite.
    pub(crate) fn deviations(
        &self,
        dynamics: &mut dyn Dynamics,
        (x, u): (&[f64], &[f64]),
        noise: &[f64],
    ) -> Result<Deviations, MpcError> {
        let (n, m) = (self.states(), self.inputs());
        let mut flow = vec![0.0; n * (n + m)];
        if let Some(row) = self.parameters.first() {
            dynamics.set_parameters(row);
        }
        let interval = Interval { t: 0.0, dt: self.dt, substeps: self.substeps.least(), u };
        Shooter::of_problem(dynamics, self).advance_with_sensitivity(dynamics, interval, &mut x.to_vec(), &mut flow);
        if let Some(&value) = flow.iter().find(|v| !v.is_finite()) {
            let what = "an entry of the linearization at the start".into();
            return Err(MpcError::Value { what, value, remedy: "give the model a [point] at which it is finite" });
        }
        let flow = DMatrix::from_row_slice(n, n + m, &flow);
        let (a, b) = (flow.columns(0, n).into_owned(), flow.columns(n, m).into_owned());
        let gain = self.infinite_horizon_gain(&a, &b, (x, u));
        let feedback = gain.is_some();
        let gain = gain.unwrap_or_else(|| DMatrix::zeros(m, n));
        let closed = &a - &b * &gain;
        let variance = |i: usize| noise.get(i).map_or(0.0, |s| s * s * self.dt);
        let added = DMatrix::from_fn(n, n, |i, j| if i == j { variance(i) } else { 0.0 });
        let mut covariances = vec![DMatrix::zeros(n, n)];
        for k in 0..self.steps {
            let next = &closed * &covariances[k] * closed.transpose() + &added;
            covariances.push(next);
        }
        Ok(Deviations { covariances, gain, feedback })
    }

    /// The gain of the infinite horizon of the stage cost at a point; none where there is no such horizon.
    fn infinite_horizon_gain(
        &self,
        a: &DMatrix<f64>,
        b: &DMatrix<f64>,
        (x, u): (&[f64], &[f64]),
    ) -> Option<DMatrix<f64>> {
        let (n, m) = (self.states(), self.inputs());
        let mut stage = self.stage.clone()?;
        let pattern = stage.hessian_pattern().to_vec();
        let (mut gradient, mut values) = (vec![0.0; n + m], vec![0.0; pattern.len()]);
        let r = self.reference(0).get(..stage.references())?.to_vec();
        stage.add_derivatives(CostPoint { x, u, t: 0.0, r: &r }, self.dt, &mut gradient, &mut values);
        let mut hessian = DMatrix::zeros(n + m, n + m);
        for (&(i, j), v) in pattern.iter().zip(values) {
            hessian[(i, j)] = 0.5 * v;
            hessian[(j, i)] = 0.5 * v;
        }
        let block = |i, j, rows, columns| hessian.view((i, j), (rows, columns)).into_owned();
        dare(a, b, &block(0, 0, n, n), &block(n, n, m, m), &block(0, n, n, m)).ok().map(|solution| solution.gain)
    }
}

impl Deviations {
    /// Standard deviation at grid point k of a quantity with the gradient `slope` with respect to states and inputs: inputs deviate
    /// by −K d.
    pub(crate) fn of(&self, slope: &[f64], k: usize) -> f64 {
        let sigma = &self.covariances[k.min(self.covariances.len() - 1)];
        let n = sigma.nrows();
        let by_state =
            |i: usize| slope[i] - slope[n..].iter().enumerate().map(|(j, g)| g * self.gain[(j, i)]).sum::<f64>();
        let total: Vec<f64> = (0..n).map(by_state).collect();
        let mut variance = 0.0;
        for i in 0..n {
            for j in 0..n {
                variance += total[i] * sigma[(i, j)] * total[j];
            }
        }
        variance.max(0.0).sqrt()
    }
}
