//! The tangential predictor: how the solution of a program moves with the measured state.
//!
//! With the set of active inequalities held, the solution is linear in the initial state, and a Riccati recursion gives its
//! gains du_k = K_k dx_k. Active inequalities are stiff springs in it.
//!
//! Source: Zavala and Biegler 2009.

use crate::ocp::{CostFunction, CostPoint, Ocp};
use crate::qp::StageProgram;
use crate::trajectory::PlannedTrajectory;
use crate::transcription::ShootingLinearization;
use nalgebra::DMatrix;

/// Distance from an inequality, per unit of its right-hand side or 1, below which it counts as active. Interior-point
/// solutions keep a distance of about their tolerance.
const ACTIVE: f64 = 1e-5;
/// Stiffness of active inequalities, relative to the largest curvature of the program.
const STIFFNESS: f64 = 1e8;

/// First variable of a stage.
fn stage_start(program: &StageProgram, k: usize) -> usize {
    if k == 0 { 0 } else { program.state(k, 0) }
}

/// Number of variables of a stage.
fn stage_size(program: &StageProgram, k: usize) -> usize {
    let end = if k < program.steps() { stage_start(program, k + 1) } else { program.variables() };
    end - stage_start(program, k)
}

/// Hessian of the variables of every stage, in their order, with a spring for every row that is active at `z`.
fn stage_hessians(program: &StageProgram, z: &[f64]) -> Vec<DMatrix<f64>> {
    let (base, size) = (|k: usize| stage_start(program, k), |k: usize| stage_size(program, k));
    let mut hessian: Vec<DMatrix<f64>> = (0..=program.steps()).map(|k| DMatrix::zeros(size(k), size(k))).collect();
    let mut stage_of = vec![0; program.variables()];
    for k in 0..=program.steps() {
        stage_of[base(k)..base(k) + size(k)].fill(k);
    }
    let mut largest = 0.0_f64;
    for ((i, j), h) in program.hessian() {
        let k = stage_of[i];
        let (i, j) = (i - base(k), j - base(k));
        hessian[k][(i, j)] = h;
        hessian[k][(j, i)] = h;
        largest = largest.max(h.abs());
    }
    let right = program.right_hand_side();
    let mut gap = right.to_vec();
    let mut rows = vec![Vec::new(); right.len()];
    for ((row, column), r) in program.rows() {
        gap[row] -= r * z[column];
        rows[row].push((column, r));
    }
    let stiffness = STIFFNESS * largest.max(1e-6);
    for (row, entries) in rows.iter().enumerate() {
        if gap[row].abs() > ACTIVE * right[row].abs().max(1.0) {
            continue;
        }
        for &(i, a) in entries {
            for &(j, b) in entries {
                let k = stage_of[i];
                hessian[k][(i - base(k), j - base(k))] += stiffness * a * b;
            }
        }
    }
    hessian
}

/// The gains of a solved program.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tangent {
    n: usize,
    m: usize,
    /// K_k, N blocks of m rows of n.
    gains: Vec<f64>,
    /// Deviation of a state at work.
    dx: Vec<f64>,
    next: Vec<f64>,
    du: Vec<f64>,
}

impl Tangent {
    /// The gains of a program without cones and blocks, at its solution `z`; `first` is ∂²l/∂(x_0, u_0), of n + m rows, times
    /// dt. `None` where the reduced Hessian is singular.
    pub(crate) fn of(program: &StageProgram, z: &[f64], flow: &[f64], first: &[f64]) -> Option<Self> {
        let (n, m, steps) = (program.states(), program.inputs(), program.steps());
        let w = n + m;
        let size = |k: usize| stage_size(program, k);
        let hessian = stage_hessians(program, z);
        // Riccati recursion over (slacks, inputs) of every stage.
        let last = size(steps) - n;
        let h = &hessian[steps];
        let mut cost = h.view((0, 0), (n, n)).clone_owned();
        if last > 0 {
            let own = h.view((n, n), (last, last)).clone_owned().cholesky()?;
            let cross = h.view((n, 0), (last, n)).clone_owned();
            cost -= cross.transpose() * own.solve(&cross);
        }
        let mut gains = vec![0.0; steps * m * n];
        for k in (0..steps).rev() {
            let states = if k == 0 { 0 } else { n };
            let own = size(k) - states;
            let slacks = own - m;
            let block = DMatrix::from_row_slice(n, w, &flow[k * n * w..(k + 1) * n * w]);
            let a = block.view((0, 0), (n, n)).clone_owned();
            let mut b = DMatrix::zeros(n, own);
            b.view_mut((0, slacks), (n, m)).copy_from(&block.view((0, n), (n, m)));
            let h = &hessian[k];
            let (mut xx, mut vx) = (DMatrix::zeros(n, n), DMatrix::zeros(own, n));
            if k == 0 {
                for i in 0..m {
                    for j in 0..n {
                        vx[(slacks + i, j)] = first[(n + i) * w + j];
                    }
                }
            } else {
                xx.copy_from(&h.view((0, 0), (n, n)));
                vx.copy_from(&h.view((n, 0), (own, n)));
            }
            let reduced = h.view((states, states), (own, own)) + b.transpose() * &cost * &b;
            let coupling = vx + b.transpose() * &cost * &a;
            let gain = -reduced.cholesky()?.solve(&coupling);
            cost = xx + a.transpose() * &cost * &a + coupling.transpose() * &gain;
            cost = (&cost + cost.transpose()) / 2.0;
            for i in 0..m {
                for j in 0..n {
                    gains[(k * m + i) * n + j] = gain[(slacks + i, j)];
                }
            }
        }
        gains.iter().all(|g| g.is_finite()).then(|| Self {
            n,
            m,
            gains,
            dx: vec![0.0; n],
            next: vec![0.0; n],
            du: vec![0.0; m],
        })
    }

    /// Moves a trajectory to the initial state `x`; whether the inputs keep their bounds without being clamped.
    pub(crate) fn follow(
        &mut self,
        x: &[f64],
        lin: &ShootingLinearization,
        ocp: &Ocp,
        trajectory: &mut PlannedTrajectory,
    ) -> bool {
        let (n, m) = (self.n, self.m);
        let w = n + m;
        for i in 0..n {
            self.dx[i] = x[i] - trajectory.x(0)[i];
        }
        let mut kept = true;
        for k in 0..trajectory.steps() {
            for j in 0..m {
                let row = &self.gains[(k * m + j) * n..(k * m + j + 1) * n];
                self.du[j] = row.iter().zip(&self.dx).map(|(g, d)| g * d).sum();
                let (min, max) = ocp.input_bounds[j];
                let u = trajectory.u(k)[j] + self.du[j];
                let slack = ACTIVE * ocp.input_trust[j];
                kept &= min - slack <= u && u <= max + slack;
                trajectory.u_mut(k)[j] = u.clamp(min, max);
            }
            trajectory.x_mut(k).iter_mut().zip(&self.dx).for_each(|(x, d)| *x += d);
            let block = &lin.jacobian[k * n * w..(k + 1) * n * w];
            for i in 0..n {
                let row = &block[i * w..(i + 1) * w];
                self.next[i] = row.iter().zip(self.dx.iter().chain(&self.du)).map(|(a, d)| a * d).sum::<f64>()
                    + lin.end[k * n + i]
                    - trajectory.x(k + 1)[i];
            }
            std::mem::swap(&mut self.dx, &mut self.next);
        }
        let end = trajectory.steps();
        trajectory.x_mut(end).iter_mut().zip(&self.dx).for_each(|(x, d)| *x += d);
        kept
    }
}

/// Second derivatives dt·∂²l/∂(x, u)² at the first grid point, in full.
pub(crate) fn first_hessian(ocp: &mut Ocp, k0: usize, trajectory: &PlannedTrajectory) -> Vec<f64> {
    let w = ocp.states() + ocp.inputs();
    let mut full = vec![0.0; w * w];
    let Some(mut cost) = ocp.stage.take() else { return full };
    let mut gradient = vec![0.0; w];
    let mut entries = vec![0.0; cost.hessian_pattern().len()];
    let r = ocp.reference(k0)[..CostFunction::references(&cost)].to_vec();
    let t = k0 as f64 * ocp.dt;
    let at = CostPoint { x: trajectory.x(0), u: trajectory.u(0), t, r: &r };
    cost.add_derivatives(at, ocp.dt, &mut gradient, &mut entries);
    for (&(i, j), h) in cost.hessian_pattern().iter().zip(&entries) {
        full[i * w + j] = *h;
        full[j * w + i] = *h;
    }
    ocp.stage = Some(cost);
    full
}
