//! The quadratic program of one iteration, on Clarabel.
//!
//! Variables are the changes (du_0; dx_1, du_1, s_1; …; dx_N, s_N, τ) with slacks s for state bounds and τ for |target miss|.
//! The sparsity is fixed by the problem, so the solver is built once and only its numbers are replaced afterwards.

use crate::error::MpcError;
use crate::ocp::Ocp;
use crate::qp_layout::{Index, Pattern};
use crate::shooting::Linearisation;
use crate::trajectory::Trajectory;
use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{NonnegativeConeT, ZeroConeT};
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT,
};

/// Settings of the interior-point solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QpSettings {
    /// Largest number of interior-point iterations.
    pub max_iterations: u32,
    /// Absolute and relative tolerance on gap and feasibility.
    pub tolerance: f64,
    /// Time after which the solver gives up, s.
    pub time_limit: f64,
    /// Weight, per unit of state scale, on violations of hard state bounds.
    pub hard_weight: f64,
}

impl Default for QpSettings {
    fn default() -> Self {
        Self { max_iterations: 100, tolerance: 1e-8, time_limit: f64::INFINITY, hard_weight: 1e4 }
    }
}

impl QpSettings {
    fn clarabel(self) -> Result<DefaultSettings<f64>, MpcError> {
        DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(self.max_iterations)
            .time_limit(self.time_limit)
            .tol_gap_abs(self.tolerance)
            .tol_gap_rel(self.tolerance)
            .tol_feas(self.tolerance)
            // Data updates need the structure as given; refinement costs almost half of the time and is not needed.
            .presolve_enable(false)
            .input_sparse_dropzeros(false)
            .iterative_refinement_enable(false)
            .max_threads(1)
            .build()
            .map_err(|_| MpcError::Value {
                what: "the tolerance of the quadratic program".into(),
                value: self.tolerance,
                remedy: "give a tolerance between 0 and 1, a positive time limit and number of iterations",
            })
    }
}

/// How the quadratic program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpStatus {
    /// To full accuracy.
    Solved,
    /// To reduced accuracy.
    Inaccurate,
    /// Not at all: iteration or time limit.
    Limit,
    /// Not at all: numerical trouble.
    Failed,
    /// The data contain a number that is not finite; nothing was solved.
    NotANumber,
}

impl QpStatus {
    /// Whether there is a step to use.
    pub fn is_usable(self) -> bool {
        matches!(self, Self::Solved | Self::Inaccurate)
    }
}

/// A step and its multipliers.
#[derive(Clone, Debug, Default)]
pub(crate) struct QpSolution {
    /// Change of the states, from x_0 on.
    pub(crate) dx: Vec<f64>,
    /// Change of the inputs.
    pub(crate) du: Vec<f64>,
    /// Multipliers of the dynamics, N rows of n.
    pub(crate) multipliers: Vec<f64>,
    pub(crate) iterations: u32,
}

/// The program: structure, numbers, solver.
pub(crate) struct Qp {
    n: usize,
    m: usize,
    steps: usize,
    settings: QpSettings,
    /// States with a bound, in order.
    bounded: Vec<usize>,
    p: CscMatrix<f64>,
    a: CscMatrix<f64>,
    q: Vec<f64>,
    b: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
    /// Positions in P: per stage the cost's pattern; then the diagonal of all variables.
    p_stage: Vec<Vec<usize>>,
    p_terminal: Vec<usize>,
    p_diagonal: Vec<usize>,
    /// Positions in A of the entries of ∂F/∂(x, u), with their index in the dense block.
    a_dynamics: Vec<Vec<(usize, usize)>>,
    input_rows: Vec<(usize, usize, bool)>,
    state_rows: Vec<(usize, usize, bool)>,
    target_rows: Vec<(usize, bool)>,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
    solver: Option<DefaultSolver<f64>>,
    pub(crate) solution: QpSolution,
}

/// Smallest curvature of any variable: keeps the program strictly convex.
const REGULARISATION: f64 = 1e-9;

impl Qp {
    /// Lays out the program for a horizon of `steps` intervals; `closure` marks the possible entries of ∂F/∂(x, u).
    pub(crate) fn new(ocp: &Ocp, steps: usize, closure: &[bool], settings: QpSettings) -> Self {
        let (n, m) = (ocp.states(), ocp.inputs());
        let w = n + m;
        let bounded: Vec<usize> = (0..n).filter(|&i| !ocp.state_bounds[i].is_free()).collect();
        let nb = bounded.len();
        let linear_targets: Vec<usize> = (0..ocp.targets.len()).filter(|&j| ocp.targets[j].linear > 0.0).collect();
        let variables = steps * (w + nb) + linear_targets.len();
        let index = Index { n, m, nb, steps };

        let mut input_rows = Vec::new();
        let mut state_rows = Vec::new();
        for k in 0..steps {
            for (j, b) in ocp.input_bounds.iter().enumerate() {
                input_rows.extend(b.1.is_finite().then_some((k, j, true)));
                input_rows.extend(b.0.is_finite().then_some((k, j, false)));
            }
            for &i in &bounded {
                state_rows.extend(ocp.state_bounds[i].max.is_finite().then_some((k + 1, i, true)));
                state_rows.extend(ocp.state_bounds[i].min.is_finite().then_some((k + 1, i, false)));
            }
        }
        let target_rows: Vec<(usize, bool)> = linear_targets.iter().flat_map(|&j| [(j, true), (j, false)]).collect();
        let inequalities = input_rows.len() + state_rows.len() + steps * nb + target_rows.len();
        let rows = steps * n + inequalities;

        let mut pattern = Pattern::new(rows, variables);
        let mut fixed = Vec::new();
        let mut a_dynamics = Vec::with_capacity(steps);
        for k in 0..steps {
            let mut slots = Vec::new();
            for i in 0..n {
                let row = k * n + i;
                fixed.push((pattern.place(row, index.x(k + 1, i)), 1.0));
                for j in (0..w).filter(|j| closure[i * w + j]) {
                    if j >= n {
                        slots.push((pattern.place(row, index.u(k, j - n)), i * w + j));
                    } else if k > 0 {
                        slots.push((pattern.place(row, index.x(k, j)), i * w + j));
                    }
                }
            }
            a_dynamics.push(slots);
        }
        let mut row = steps * n;
        let sign = |upper: bool| if upper { 1.0 } else { -1.0 };
        for &(k, j, upper) in &input_rows {
            fixed.push((pattern.place(row, index.u(k, j)), sign(upper)));
            row += 1;
        }
        for &(k, i, upper) in &state_rows {
            let place = bounded.iter().position(|&b| b == i).unwrap_or(0);
            fixed.push((pattern.place(row, index.x(k, i)), sign(upper)));
            fixed.push((pattern.place(row, index.slack(k, place)), -1.0));
            row += 1;
        }
        for k in 1..=steps {
            for place in 0..nb {
                fixed.push((pattern.place(row, index.slack(k, place)), -1.0));
                row += 1;
            }
        }
        for (r, &(j, upper)) in target_rows.iter().enumerate() {
            fixed.push((pattern.place(row, index.x(steps, ocp.targets[j].state)), sign(upper)));
            fixed.push((pattern.place(row, index.tau(r / 2)), -1.0));
            row += 1;
        }
        let (mut a, position) = pattern.build();
        for (slot, value) in fixed {
            a.nzval[position[slot]] = value;
        }
        for (slot, _) in a_dynamics.iter_mut().flatten() {
            *slot = position[*slot];
        }

        let mut pattern = Pattern::new(variables, variables);
        let mut p_diagonal: Vec<usize> = (0..variables).map(|v| pattern.place(v, v)).collect();
        let stage_pattern = ocp.stage.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        let terminal_pattern = ocp.terminal.as_ref().map_or(&[][..], |c| c.hessian_pattern());
        let mut p_stage = Vec::with_capacity(steps);
        for k in 0..steps {
            let slots: Vec<usize> = stage_pattern
                .iter()
                .map(|&(i, j)| {
                    let (Some(i), Some(j)) = (index.variable(k, i), index.variable(k, j)) else {
                        return usize::MAX;
                    };
                    if i == j { p_diagonal[i] } else { pattern.place(i.min(j), i.max(j)) }
                })
                .collect();
            p_stage.push(slots);
        }
        let mut p_terminal: Vec<usize> = terminal_pattern
            .iter()
            .map(|&(i, j)| {
                let (i, j) = (index.x(steps, i), index.x(steps, j));
                if i == j { p_diagonal[i] } else { pattern.place(i, j) }
            })
            .collect();
        let (p, position) = pattern.build();
        let resolve = |slot: &mut usize| {
            if *slot != usize::MAX {
                *slot = position[*slot];
            }
        };
        p_stage.iter_mut().flatten().for_each(resolve);
        p_terminal.iter_mut().for_each(resolve);
        p_diagonal.iter_mut().for_each(resolve);

        Self {
            n,
            m,
            steps,
            settings,
            bounded,
            q: vec![0.0; variables],
            b: vec![0.0; rows],
            cones: vec![ZeroConeT(steps * n), NonnegativeConeT(inequalities)],
            p,
            a,
            p_stage,
            p_terminal,
            p_diagonal,
            a_dynamics,
            input_rows,
            state_rows,
            target_rows,
            gradient: vec![0.0; w],
            hessian: Vec::new(),
            solver: None,
            solution: QpSolution::default(),
        }
    }

    /// Number of intervals.
    pub(crate) fn steps(&self) -> usize {
        self.steps
    }

    /// Sets the limits of the solutions that follow: interior-point iterations, and time in s.
    pub(crate) fn set_limits(&mut self, max_iterations: u32, time_limit: f64) -> Result<(), MpcError> {
        if (self.settings.max_iterations, self.settings.time_limit) == (max_iterations, time_limit) {
            return Ok(());
        }
        self.settings.max_iterations = max_iterations;
        self.settings.time_limit = time_limit;
        let settings = self.settings.clarabel()?;
        if self.solver.as_mut().is_some_and(|s| s.update_settings(settings).is_err()) {
            // The next solution builds a new solver with them.
            self.solver = None;
        }
        Ok(())
    }

    fn index(&self) -> Index {
        Index { n: self.n, m: self.m, nb: self.bounded.len(), steps: self.steps }
    }

    /// Fills in every number. `k0` is the grid point of the run at which the horizon starts, `proximal` the weight λ of the
    /// term dt·λ/2·Σ (change/trust)².
    pub(crate) fn assemble(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &Trajectory,
        lin: &Linearisation,
        proximal: f64,
    ) {
        let (n, m, steps) = (self.n, self.m, self.steps);
        let w = n + m;
        let index = self.index();
        self.p.nzval.fill(0.0);
        self.q.fill(0.0);
        for &d in &self.p_diagonal {
            self.p.nzval[d] = REGULARISATION;
        }
        for k in 0..steps {
            for j in 0..m {
                self.p.nzval[self.p_diagonal[index.u(k, j)]] += proximal * ocp.dt / ocp.input_trust[j].powi(2);
            }
            for i in 0..n {
                self.p.nzval[self.p_diagonal[index.x(k + 1, i)]] += proximal * ocp.dt / ocp.state_trust[i].powi(2);
            }
        }
        if let Some(mut cost) = ocp.stage.take() {
            for k in 0..steps {
                self.gradient.fill(0.0);
                self.hessian.clear();
                self.hessian.resize(cost.hessian_pattern().len(), 0.0);
                let r = &ocp.reference(k0 + k)[..cost.references()];
                let t = (k0 + k) as f64 * ocp.dt;
                let (x, u) = (trajectory.x(k), trajectory.u(k));
                cost.add_derivatives(x, u, t, r, ocp.dt, &mut self.gradient, &mut self.hessian);
                for (v, g) in self.gradient.iter().enumerate() {
                    if let Some(column) = index.variable(k, v) {
                        self.q[column] += g;
                    }
                }
                for (&slot, h) in self.p_stage[k].iter().zip(&self.hessian) {
                    if slot != usize::MAX {
                        self.p.nzval[slot] += h;
                    }
                }
            }
            ocp.stage = Some(cost);
        }
        if let Some(mut cost) = ocp.terminal.take() {
            self.gradient.fill(0.0);
            self.hessian.clear();
            self.hessian.resize(cost.hessian_pattern().len(), 0.0);
            let r = &ocp.reference(k0 + steps)[..cost.references()];
            let t = (k0 + steps) as f64 * ocp.dt;
            cost.add_derivatives(trajectory.x(steps), &[], t, r, 1.0, &mut self.gradient[..n], &mut self.hessian);
            for i in 0..n {
                self.q[index.x(steps, i)] += self.gradient[i];
            }
            for (&slot, h) in self.p_terminal.iter().zip(&self.hessian) {
                self.p.nzval[slot] += h;
            }
            ocp.terminal = Some(cost);
        }
        for t in &ocp.targets {
            let column = index.x(steps, t.state);
            let e = trajectory.x(steps)[t.state] - t.value;
            self.q[column] += 2.0 * t.quadratic * e;
            self.p.nzval[self.p_diagonal[column]] += 2.0 * t.quadratic;
        }
        for (place, &i) in self.bounded.iter().enumerate() {
            let (linear, quadratic) = ocp.weights(i, self.settings.hard_weight);
            for k in 1..=steps {
                let column = index.slack(k, place);
                self.q[column] = linear;
                self.p.nzval[self.p_diagonal[column]] += 2.0 * quadratic;
            }
        }
        for r in (0..self.target_rows.len()).step_by(2) {
            self.q[index.tau(r / 2)] = ocp.targets[self.target_rows[r].0].linear;
        }

        for k in 0..steps {
            for &(position, dense) in &self.a_dynamics[k] {
                self.a.nzval[position] = -lin.jacobian[k * n * w + dense];
            }
            for i in 0..n {
                self.b[k * n + i] = lin.end[k * n + i] - trajectory.x(k + 1)[i];
            }
        }
        let mut row = steps * n;
        for &(k, j, upper) in &self.input_rows {
            let v = trajectory.u(k)[j];
            self.b[row] = if upper { ocp.input_bounds[j].1 - v } else { v - ocp.input_bounds[j].0 };
            row += 1;
        }
        for &(k, i, upper) in &self.state_rows {
            let v = trajectory.x(k)[i];
            self.b[row] = if upper { ocp.state_bounds[i].max - v } else { v - ocp.state_bounds[i].min };
            row += 1;
        }
        row += steps * self.bounded.len();
        for &(j, upper) in &self.target_rows {
            let t = &ocp.targets[j];
            let e = trajectory.x(steps)[t.state] - t.value;
            self.b[row] = if upper { -e } else { e };
            row += 1;
        }
    }

    /// Replaces the numbers of the first interval alone, after its state has become known.
    pub(crate) fn update_first_interval(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &Trajectory,
        lin: &Linearisation,
    ) {
        if let Some(mut cost) = ocp.stage.take() {
            self.gradient.fill(0.0);
            self.hessian.clear();
            self.hessian.resize(cost.hessian_pattern().len(), 0.0);
            let r = &ocp.reference(k0)[..cost.references()];
            let (x, u) = (trajectory.x(0), trajectory.u(0));
            let t = k0 as f64 * ocp.dt;
            cost.add_derivatives(x, u, t, r, ocp.dt, &mut self.gradient, &mut self.hessian);
            self.q[..self.m].copy_from_slice(&self.gradient[self.n..]);
            ocp.stage = Some(cost);
        }
        for &(position, dense) in &self.a_dynamics[0] {
            self.a.nzval[position] = -lin.jacobian[dense];
        }
        for i in 0..self.n {
            self.b[i] = lin.end[i] - trajectory.x(1)[i];
        }
    }

    /// Solves; the step is in [`Qp::solution`] when the status says so.
    pub(crate) fn solve(&mut self) -> Result<QpStatus, MpcError> {
        let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
        if !(finite(&self.p.nzval) && finite(&self.q) && finite(&self.a.nzval) && finite(&self.b)) {
            return Ok(QpStatus::NotANumber);
        }
        let updated =
            self.solver.as_mut().is_some_and(|s| s.update_data(&self.p.nzval, &self.q, &self.a.nzval, &self.b).is_ok());
        if !updated {
            let settings = self.settings.clarabel()?;
            // A structure that the solver refuses would be a defect of this module; it is reported as a failed program.
            match DefaultSolver::new(&self.p, &self.q, &self.a, &self.b, &self.cones, settings) {
                Ok(s) => self.solver = Some(s),
                Err(_) => return Ok(QpStatus::Failed),
            }
        }
        let Some(solver) = self.solver.as_mut() else { return Ok(QpStatus::Failed) };
        solver.solve();
        let status = match solver.solution.status {
            SolverStatus::Solved => QpStatus::Solved,
            SolverStatus::AlmostSolved => QpStatus::Inaccurate,
            SolverStatus::MaxIterations | SolverStatus::MaxTime => QpStatus::Limit,
            _ => QpStatus::Failed,
        };
        let (n, m, steps) = (self.n, self.m, self.steps);
        let index = Index { n, m, nb: self.bounded.len(), steps };
        let z = &solver.solution.x;
        let s = &mut self.solution;
        s.iterations = solver.solution.iterations;
        s.dx.clear();
        s.dx.resize(n, 0.0);
        s.du.clear();
        for k in 0..steps {
            s.du.extend_from_slice(&z[index.u(k, 0)..index.u(k, 0) + m]);
            s.dx.extend_from_slice(&z[index.x(k + 1, 0)..index.x(k + 1, 0) + n]);
        }
        s.multipliers.clear();
        s.multipliers.extend_from_slice(&solver.solution.z[..steps * n]);
        if status.is_usable() && !(finite(&s.dx) && finite(&s.du)) {
            return Ok(QpStatus::Failed);
        }
        Ok(status)
    }
}
