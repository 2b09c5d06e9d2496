//! Moving-horizon estimation.

use super::augmented::{Augmented, LinearizedInterval};
use super::estimate::{Estimate, EstimateStatus, Estimator};
use super::kalman::{AbsorbRoom, ExtendedKalman, ScalarOutput, absorb, check_input, prior, propagate, write_estimate};
use super::problem::{EstimationProblem, Outliers};
use crate::error::{MpcError, check_length};
use crate::ocp::{Bounds, CostFunction, Ocp, Softness};
use crate::qp::{Qp, QpSettings};
use crate::trajectory::PlannedTrajectory;
use crate::transcription::ShootingLinearization;
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
/// Source: Kühl, Diehl, Kraus, Schlöder, and Bock 2011.
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
    trajectory: PlannedTrajectory,
    lin: ShootingLinearization,
    /// Intervals that let in the prior.
    entries: usize,
    /// Columns per interval: noise, or a part of ζ.
    columns: usize,
    room: Room,
}

/// Memory of the estimator, used at every sample anew.
struct Room {
    flows: Vec<LinearizedInterval>,
    /// L.
    root: DMatrix<f64>,
    product: DMatrix<f64>,
    absorb: AbsorbRoom,
    /// Measurements with angles at the turn of the prediction.
    unwrapped: Vec<f64>,
    /// The node that has left the horizon.
    spare: Option<Node>,
}

impl Room {
    fn of(model: &Augmented, horizon: usize) -> Self {
        let n = model.size();
        Self {
            flows: (0..=horizon).map(|_| LinearizedInterval::of(model)).collect(),
            root: DMatrix::zeros(n, n),
            product: DMatrix::zeros(n, n),
            absorb: AbsorbRoom::of(n),
            unwrapped: vec![0.0; model.sensors.len()],
            spare: None,
        }
    }
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
            trajectory: PlannedTrajectory::constant(steps, mean.as_slice(), &vec![0.0; columns]),
            lin: ShootingLinearization {
                end: vec![0.0; steps * n],
                jacobian: vec![0.0; steps * n * (n + columns)],
                ..ShootingLinearization::default()
            },
            hidden_before: vec![false; n],
            room: Room::of(&head.model, settings.horizon),
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
    fn unwrap(&mut self, y: &[f64]) {
        let t = self.head.time();
        self.head.model.measure(t, self.head.z.as_slice());
        let (h, _) = self.head.model.measured();
        for (i, unwrapped) in self.room.unwrapped.iter_mut().enumerate() {
            *unwrapped = h[i] + self.head.model.residual(i, y[i], h[i]);
        }
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
        let n = self.mean.len();
        model.measure(t, node.z.as_slice());
        let (h, c) = model.measured();
        for (i, &y) in node.y.iter().enumerate().filter(|(_, y)| y.is_finite()) {
            let row = &c[i * n..(i + 1) * n];
            let moved: f64 = (0..n).map(|j| row[j] * (self.mean[j] - node.z[j])).sum();
            let output = ScalarOutput { row, residual: y - h[i] - moved, noise: model.sensors[i].0 };
            let hidden = &self.hidden_before;
            absorb(&mut self.mean, &mut self.covariance, &output, self.outliers, hidden, &mut self.room.absorb);
        }
        let Room { flows, product, .. } = &mut self.room;
        let step = &mut flows[0];
        model.linearize(t, node.z.as_slice(), &node.u, &node.w, node.hide, step);
        // The mean relative to the point at which the interval is linearized; the end takes its place.
        self.mean -= &node.z;
        for i in 0..n {
            let moved: f64 = (0..n).map(|j| step.f[(i, j)] * self.mean[j]).sum();
            let noise: f64 = node.w.iter().enumerate().map(|(k, w)| step.g[(i, k)] * w).sum();
            step.end[i] += moved - noise;
        }
        self.mean.copy_from(&step.end);
        propagate(&mut self.covariance, &step.f, &step.g, product);
        for (v, b) in self.mean.iter_mut().zip(&model.bounds) {
            *v = v.clamp(b.0, b.1);
        }
        self.hidden_before.copy_from_slice(&step.hidden);
        self.room.spare = Some(node);
    }

    /// One quadratic program; false if it gave no usable step.
    fn iterate(&mut self) -> Result<bool, MpcError> {
        let (n, noise) = (self.mean.len(), self.head.model.noise.len());
        let width = n + self.columns;
        let steps = self.ocp.steps;
        let intervals = self.nodes.len() - 1;
        let first = steps - intervals;
        let t0 = self.start_time();
        let Room { flows, root, .. } = &mut self.room;
        let flows = &mut flows[..intervals];
        for (k, (node, flow)) in self.nodes.iter().zip(flows.iter_mut()).enumerate() {
            let t = t0 + k as f64 * self.dt;
            self.head.model.linearize(t, node.z.as_slice(), &node.u, &node.w, node.hide, flow);
        }
        semidefinite_root(&self.covariance, root);
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
        if references.is_empty() {
            references.resize(self.ocp.steps + 1, vec![0.0; 1 + 2 * p]);
        }
        for row in &mut references[..first] {
            row.fill(0.0);
        }
        for (k, row) in references[first..].iter_mut().enumerate() {
            let t = t0 + k as f64 * self.dt;
            let node = &self.nodes[k];
            self.head.model.measure(t, node.z.as_slice());
            let (h, _) = self.head.model.measured();
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

    /// Solves for the horizon; how that went.
    fn solve(&mut self, lost: usize) -> Result<EstimateStatus, MpcError> {
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
        Ok(status)
    }

    /// Restarts from the filter's estimate.
    fn restart(&mut self) -> EstimateStatus {
        self.mean.copy_from(&self.head.z);
        self.covariance.copy_from(&self.head.p);
        self.hidden_before.fill(false);
        let y = vec![f64::NAN; self.head.model.sensors.len()];
        self.nodes.clear();
        self.nodes.push_back(Node { z: self.mean.clone(), w: Vec::new(), u: Vec::new(), y, hide: true });
        EstimateStatus::Restarted
    }

    /// Adds the newest point, at the filter's estimate and with the unwrapped measurement.
    fn push_newest(&mut self) {
        let spare = self.room.spare.take();
        let mut node = spare.unwrap_or_else(|| Node {
            z: self.head.z.clone(),
            w: Vec::new(),
            u: Vec::new(),
            y: Vec::new(),
            hide: true,
        });
        node.z.copy_from(&self.head.z);
        node.w.clear();
        node.u.clear();
        node.y.clone_from(&self.room.unwrapped);
        node.hide = true;
        self.nodes.push_back(node);
    }

    fn correct_status(&mut self, y: &[f64]) -> Result<EstimateStatus, MpcError> {
        check_length("the measurement", y.len(), self.head.model.sensors.len())?;
        self.unwrap(y);
        if self.head.take_in_first(y) == EstimateStatus::Restarted {
            return Ok(self.restart());
        }
        if let Some(last) = self.nodes.back_mut() {
            last.y.clone_from(&self.room.unwrapped);
            last.z.copy_from(&self.head.z);
        }
        self.solve(y.iter().filter(|v| !v.is_finite()).count())
    }

    fn update_status(&mut self, u: &[f64], y: &[f64]) -> Result<EstimateStatus, MpcError> {
        check_length("the measurement", y.len(), self.head.model.sensors.len())?;
        check_input(&self.head.model, u)?;
        self.head.predict(u);
        let hide = self.head.believes_sticking();
        self.unwrap(y);
        let lost = self.head.take_in(y);
        if self.head.finish(lost) == EstimateStatus::Restarted {
            return Ok(self.restart());
        }
        let noise = self.head.model.noise.len();
        if let Some(last) = self.nodes.back_mut() {
            last.u.clear();
            last.u.extend_from_slice(u);
            last.w.clear();
            last.w.resize(noise, 0.0);
            last.hide = hide && self.head.believes_sticking();
        }
        self.push_newest();
        if self.nodes.len() > self.settings.horizon + 1 {
            self.drop_oldest();
        }
        self.solve(lost)
    }
}

impl Estimator for MovingHorizon {
    fn correct_into(&mut self, y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        let status = self.correct_status(y)?;
        write_estimate(&self.head.model, &self.head.z, &self.head.p, status, estimate);
        Ok(())
    }

    fn update_into(&mut self, u: &[f64], y: &[f64], estimate: &mut Estimate) -> Result<(), MpcError> {
        let status = self.update_status(u, y)?;
        write_estimate(&self.head.model, &self.head.z, &self.head.p, status, estimate);
        Ok(())
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
fn semidefinite_root(p: &DMatrix<f64>, l: &mut DMatrix<f64>) {
    let n = p.nrows();
    l.fill(0.0);
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
}
