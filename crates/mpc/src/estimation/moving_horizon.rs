//! Moving-horizon estimation.

use super::augmented::{Augmented, LinearizedInterval};
use super::estimate::{Estimate, EstimateStatus, Estimator};
use super::kalman::{ExtendedKalman, absorb, check_input, estimate, prior};
use super::problem::{EstimationProblem, Outliers};
use crate::error::{MpcError, check_length};
use crate::ocp::{Bounds, CostFunction, Ocp, Softness};
use crate::qp::{Qp, QpSettings};
use crate::trajectory::Trajectory;
use crate::transcription::Linearization;
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;

/// Settings of [`MovingHorizon`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingHorizonSettings {
    /// Number of intervals that are looked back on.
    pub horizon: usize,
    /// Quadratic programs per sample.
    pub iterations: usize,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
}

impl Default for MovingHorizonSettings {
    fn default() -> Self {
        Self { horizon: 15, iterations: 1, qp: QpSettings::default() }
    }
}

/// Standardized noise beyond this is taken to be impossible.
const UNHEARD_OF: f64 = 1e3;

/// A grid point of the horizon and the interval that follows it.
struct Node {
    z: DVector<f64>,
    /// Standardized noise of the interval that follows.
    w: Vec<f64>,
    /// Input over the interval that follows; empty at the last node.
    u: Vec<f64>,
    y: Vec<f64>,
    /// Whether friction may be taken to stick in the interval that follows.
    hide: bool,
}

/// Moving-horizon estimation by real-time iteration: at every sample, one quadratic program (or a few) over the last N
/// intervals on the exact flow,
///
/// ```text
/// min  ½‖ζ‖² + ½ Σ ‖w_k‖² + ½ Σ ‖(y_k − h(z_k))/σ‖²   over ζ, z, w
/// s.t. z_0 = z̄ + L ζ,   z_{k+1} = F(z_k, u_k) + G_k w_k,   z in its bounds
/// ```
///
/// with states, parameters and disturbances in z. The prior (z̄, L Lᵀ) follows the horizon by the update of the extended Kalman
/// filter, linearized on the trajectory that the horizon has found. On a linear model without bounds this is the Kalman
/// filter.
///
/// The program is the controller's: the prior is let in by a few intervals before the horizon in which nothing moves but by
/// ζ. A filter goes ahead of the horizon: it gives the guess for the newest point, the standard deviations, and the estimate
/// when the program fails.
///
/// Source: P. Kühl, M. Diehl, T. Kraus, J. P. Schlöder, H. G. Bock, A real-time algorithm for moving horizon state and
/// parameter estimation, Computers & Chemical Engineering 35 (2011).
pub struct MovingHorizon {
    head: ExtendedKalman,
    settings: MovingHorizonSettings,
    outliers: Outliers,
    dt: f64,
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    /// What friction hid in the interval before the horizon.
    hidden_before: Vec<bool>,
    nodes: VecDeque<Node>,
    ocp: Ocp,
    qp: Qp,
    trajectory: Trajectory,
    lin: Linearization,
    /// Intervals that let in the prior.
    entries: usize,
    /// Columns per interval: noise, or a part of ζ.
    columns: usize,
}

impl MovingHorizon {
    /// An estimator at time 0.
    ///
    /// # Errors
    /// If the problem contradicts itself, names something that the model does not have, or the horizon is empty.
    pub fn new(problem: &EstimationProblem, settings: MovingHorizonSettings) -> Result<Self, MpcError> {
        for (what, value) in [("the estimation horizon", settings.horizon), ("the iterations", settings.iterations)] {
            if value == 0 {
                return Err(MpcError::Value { what: what.into(), value: 0.0, remedy: "give 1 or more" });
            }
        }
        let head = ExtendedKalman::new(problem)?;
        let model = &head.model;
        let n = model.size();
        let columns = model.noise.len().max(3).min(n.max(model.noise.len()));
        let entries = n.div_ceil(columns);
        let steps = entries + settings.horizon;
        let mut ocp = Ocp::new(n, columns, steps, 1.0);
        let (stage, terminal) = costs(problem, n, columns)?;
        (ocp.stage, ocp.terminal) = (Some(stage), Some(terminal));
        for (bound, &(min, max)) in ocp.state_bounds.iter_mut().zip(&model.bounds) {
            *bound = Bounds { min, max, softness: Softness::Hard };
        }
        let mut closure = vec![true; n * (n + columns)];
        for i in 0..n {
            closure[i * (n + columns)..i * (n + columns) + n].copy_from_slice(&model.flow_pattern(i));
        }
        if model.bounds.iter().all(|b| b.0 == f64::NEG_INFINITY && b.1 == f64::INFINITY) {
            // An interior-point method stalls short of its tolerance when there is no inequality at all.
            ocp.input_bounds.fill((-UNHEARD_OF, UNHEARD_OF));
        }
        let qp = Qp::new(&ocp, steps, &closure, settings.qp);
        let (mean, covariance) = (model.start.clone(), prior(model));
        let node = Node { z: mean.clone(), w: Vec::new(), u: Vec::new(), y: Vec::new(), hide: true };
        Ok(Self {
            trajectory: Trajectory::constant(steps, mean.as_slice(), &vec![0.0; columns]),
            lin: Linearization {
                end: vec![0.0; steps * n],
                jacobian: vec![0.0; steps * n * (n + columns)],
                ..Linearization::default()
            },
            hidden_before: vec![false; n],
            nodes: VecDeque::from([node]),
            head,
            settings,
            outliers: problem.outliers,
            dt: problem.dt,
            mean,
            covariance,
            ocp,
            qp,
            entries,
            columns,
        })
    }

    /// States, parameters and disturbances at the grid points of the horizon, oldest first: the smoothed past.
    pub fn horizon(&self) -> Vec<Vec<f64>> {
        self.nodes.iter().map(|n| n.z.as_slice().to_vec()).collect()
    }

    /// Time of the oldest grid point.
    fn start_time(&self) -> f64 {
        self.head.time() - (self.nodes.len() - 1) as f64 * self.dt
    }

    /// Measurements at the newest point with angles taken to the turn of the prediction.
    fn unwrapped(&mut self, y: &[f64]) -> Vec<f64> {
        let t = self.head.time();
        let (h, _) = self.head.model.outputs(t, self.head.z.as_slice());
        y.iter().enumerate().map(|(i, &y)| h[i] + self.head.model.residual(i, y, h[i])).collect()
    }

    /// Huber's weight of a residual in standard deviations.
    fn weight(&self, residual: f64) -> f64 {
        match self.outliers {
            Outliers::Trust => 1.0,
            Outliers::Huber(threshold) => (threshold / residual.abs()).min(1.0),
        }
    }

    /// Leaves the oldest interval to the prior.
    fn drop_oldest(&mut self) {
        let t = self.start_time();
        let Some(node) = self.nodes.pop_front() else { return };
        let model = &mut self.head.model;
        let (h, c) = model.outputs(t, node.z.as_slice());
        for (i, &y) in node.y.iter().enumerate().filter(|(_, y)| y.is_finite()) {
            let row = c.row(i).into_owned();
            let r = y - h[i] - (&row * (&self.mean - &node.z))[(0, 0)];
            let noise = model.sensors[i].0;
            absorb(&mut self.mean, &mut self.covariance, &row, r, noise, self.outliers, &self.hidden_before);
        }
        let step = model.interval(t, node.z.as_slice(), &node.u, &node.w, node.hide);
        self.mean = &step.end + &step.f * (&self.mean - &node.z) - &step.g * DVector::from_vec(node.w);
        self.covariance = &step.f * &self.covariance * step.f.transpose() + &step.g * step.g.transpose();
        for (v, b) in self.mean.iter_mut().zip(&model.bounds) {
            *v = v.clamp(b.0, b.1);
        }
        self.hidden_before = step.hidden;
    }

    /// One quadratic program; false if it gave no usable step.
    fn iterate(&mut self) -> Result<bool, MpcError> {
        let (n, noise) = (self.mean.len(), self.head.model.noise.len());
        let width = n + self.columns;
        let steps = self.ocp.steps;
        let intervals = self.nodes.len() - 1;
        let first = steps - intervals;
        let t0 = self.start_time();
        let mut flows: Vec<LinearizedInterval> = Vec::with_capacity(intervals);
        for (k, node) in self.nodes.iter().take(intervals).enumerate() {
            let t = t0 + k as f64 * self.dt;
            flows.push(self.head.model.interval(t, node.z.as_slice(), &node.u, &node.w, node.hide));
        }
        let mut root = semidefinite_root(&self.covariance);
        for j in (0..n).filter(|&j| !flows.is_empty() && flows.iter().all(|f| f.hidden[j])) {
            root.row_mut(j).fill(0.0);
        }
        self.lin.jacobian.fill(0.0);
        for k in 0..first {
            self.trajectory.x_mut(k).copy_from_slice(self.mean.as_slice());
            self.trajectory.u_mut(k).fill(0.0);
            self.lin.end[k * n..(k + 1) * n].copy_from_slice(self.mean.as_slice());
            let block = &mut self.lin.jacobian[k * n * width..(k + 1) * n * width];
            for i in 0..n {
                block[i * width + i] = 1.0;
                for c in 0..self.columns {
                    let from = k * self.columns + c;
                    block[i * width + n + c] = if k < self.entries && from < n { root[(i, from)] } else { 0.0 };
                }
            }
        }
        for (node, k) in self.nodes.iter().zip(first..) {
            self.trajectory.x_mut(k).copy_from_slice(node.z.as_slice());
        }
        for ((flow, node), k) in flows.iter().zip(&self.nodes).zip(first..) {
            let row = self.trajectory.u_mut(k);
            row.fill(0.0);
            row[..noise].copy_from_slice(&node.w);
            self.lin.end[k * n..(k + 1) * n].copy_from_slice(flow.end.as_slice());
            let block = &mut self.lin.jacobian[k * n * width..(k + 1) * n * width];
            for i in 0..n {
                for j in 0..n {
                    block[i * width + j] = flow.f[(i, j)];
                }
                for c in 0..noise {
                    block[i * width + n + c] = flow.g[(i, c)];
                }
            }
        }
        self.refer(first, t0);
        self.qp.assemble(&mut self.ocp, 0, &self.trajectory, &self.lin, 0.0);
        if !self.qp.solve()?.is_usable() {
            return Ok(false);
        }
        let step = &self.qp.solution;
        for (node, k) in self.nodes.iter_mut().zip(first..) {
            for i in 0..n {
                let (min, max) = self.head.model.bounds[i];
                node.z[i] = (node.z[i] + step.dx[k * n + i]).clamp(min, max);
            }
            for (c, w) in node.w.iter_mut().enumerate() {
                *w += step.du[k * self.columns + c];
            }
        }
        Ok(true)
    }

    /// Writes time, measurements and weights of every grid point into the references of the cost.
    fn refer(&mut self, first: usize, t0: f64) {
        let p = self.head.model.sensors.len();
        let mut references = std::mem::take(&mut self.ocp.references);
        references.resize(self.ocp.steps + 1, vec![0.0; 1 + 2 * p]);
        for row in &mut references[..first] {
            row.fill(0.0);
        }
        for (k, row) in references[first..].iter_mut().enumerate() {
            let t = t0 + k as f64 * self.dt;
            let node = &self.nodes[k];
            let (h, _) = self.head.model.outputs(t, node.z.as_slice());
            row.fill(0.0);
            row[0] = t;
            for (i, &y) in node.y.iter().enumerate().filter(|(_, y)| y.is_finite()) {
                let variance = self.head.model.sensors[i].0;
                row[1 + i] = y;
                row[1 + p + i] = self.weight((y - h[i]) / variance.sqrt()) / variance;
            }
        }
        self.ocp.references = references;
    }

    /// Solves for the horizon and makes an estimate of its end.
    fn solve(&mut self, lost: usize) -> Result<Estimate, MpcError> {
        let mut status = if lost == self.head.model.sensors.len() {
            EstimateStatus::Predicted
        } else {
            EstimateStatus::Updated { lost }
        };
        for _ in 0..self.settings.iterations {
            if !self.iterate()? {
                status = EstimateStatus::Fallback;
                break;
            }
        }
        if let Some(last) = self.nodes.back() {
            self.head.z.copy_from(&last.z);
        }
        Ok(estimate(&self.head.model, &self.head.z, &self.head.p, status))
    }

    /// Restarts from the filter's estimate.
    fn restart(&mut self) -> Estimate {
        self.mean.copy_from(&self.head.z);
        self.covariance.copy_from(&self.head.p);
        self.hidden_before.fill(false);
        let y = vec![f64::NAN; self.head.model.sensors.len()];
        self.nodes = VecDeque::from([Node { z: self.mean.clone(), w: Vec::new(), u: Vec::new(), y, hide: true }]);
        estimate(&self.head.model, &self.head.z, &self.head.p, EstimateStatus::Restarted)
    }
}

impl Estimator for MovingHorizon {
    fn correct(&mut self, y: &[f64]) -> Result<Estimate, MpcError> {
        check_length("the measurement", y.len(), self.head.model.sensors.len())?;
        let unwrapped = self.unwrapped(y);
        let guess = self.head.correct(y)?;
        if guess.status == EstimateStatus::Restarted {
            return Ok(self.restart());
        }
        let z = self.head.z.clone();
        if let Some(last) = self.nodes.back_mut() {
            last.y = unwrapped;
            last.z = z;
        }
        self.solve(y.iter().filter(|v| !v.is_finite()).count())
    }

    fn update(&mut self, u: &[f64], y: &[f64]) -> Result<Estimate, MpcError> {
        check_length("the measurement", y.len(), self.head.model.sensors.len())?;
        check_input(&self.head.model, u)?;
        let before = self.head.z.clone();
        let hidden = self.head.predict(u);
        let hide = self.head.believes_sticking();
        let unwrapped = self.unwrapped(y);
        let lost = self.head.take_in(y, &hidden);
        if self.head.finish(lost, &before).status == EstimateStatus::Restarted {
            return Ok(self.restart());
        }
        if let Some(last) = self.nodes.back_mut() {
            last.u = u.to_vec();
            last.w = vec![0.0; self.head.model.noise.len()];
            last.hide = hide && self.head.believes_sticking();
        }
        self.nodes.push_back(Node { z: self.head.z.clone(), w: Vec::new(), u: Vec::new(), y: unwrapped, hide: true });
        if self.nodes.len() > self.settings.horizon + 1 {
            self.drop_oldest();
        }
        self.solve(lost)
    }
}

/// Stage and terminal cost: squared standardized noise, and weighted squares of the residuals.
fn costs(problem: &EstimationProblem, n: usize, columns: usize) -> Result<(CostFunction, CostFunction), MpcError> {
    let (mut system, outputs) = Augmented::symbolic(problem)?;
    let outputs = system.with_values(&outputs);
    let pool = &mut system.pool;
    let (time, now) = (pool.symbol("t"), pool.symbol("reference#t"));
    let (t, at) = (pool.sym(time), pool.sym(now));
    let outputs = pool.substitute_all(&outputs, &[(t, at)].into_iter().collect());
    let mut references = vec![now];
    references.extend((0..outputs.len()).map(|i| pool.symbol(&format!("measured#{i}"))));
    references.extend((0..outputs.len()).map(|i| pool.symbol(&format!("weight#{i}"))));
    let inputs: Vec<_> = (0..columns).map(|i| pool.symbol(&format!("w#{i}"))).collect();
    let half = pool.ratio(1, 2);
    let mut residuals = pool.int(0);
    for (i, &h) in outputs.iter().enumerate() {
        let (y, weight) = (pool.sym(references[1 + i]), pool.sym(references[1 + outputs.len() + i]));
        let r = pool.sub(y, h);
        let square = pool.powi(r, 2);
        let term = pool.mul(weight, square);
        residuals = pool.add(residuals, term);
    }
    let residuals = pool.mul(half, residuals);
    let mut stage = residuals;
    for &w in &inputs {
        let w = pool.sym(w);
        let square = pool.powi(w, 2);
        let term = pool.mul(half, square);
        stage = pool.add(stage, term);
    }
    let states = system.states[..n].to_vec();
    Ok((
        CostFunction::compile(&mut system.pool, time, &states, &inputs, &references, stage)?,
        CostFunction::compile(&mut system.pool, time, &states, &[], &references, residuals)?,
    ))
}

/// A lower triangular L with L Lᵀ = P for a positive semidefinite P; directions without spread get a zero column.
fn semidefinite_root(p: &DMatrix<f64>) -> DMatrix<f64> {
    let n = p.nrows();
    let mut l = DMatrix::zeros(n, n);
    for j in 0..n {
        let pivot = p[(j, j)] - (0..j).map(|k: usize| l[(j, k)] * l[(j, k)]).sum::<f64>();
        if pivot <= 1e-13 * p[(j, j)].max(0.0) {
            continue;
        }
        let root = pivot.sqrt();
        l[(j, j)] = root;
        for i in j + 1..n {
            let sum: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum();
            l[(i, j)] = (p[(i, j)] - sum) / root;
        }
    }
    l
}
