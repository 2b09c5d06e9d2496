//! The quadratic program of one iteration, on a Riccati recursion or on Clarabel.
//!
//! An assembly fills a [`StageProgram`] from the problem; a [`QpBackend`] solves it. The structure is fixed by the problem,
//! so everything is laid out once and only numbers are replaced afterwards. Hard constraints on states are exact penalties
//! with slacks: a program without a feasible point becomes the one with the smallest weighted violation, and its status says
//! so.

mod assembly;
mod automatic;
mod backend;
mod clarabel;
mod condensing;
mod elimination;
mod exact_hessian;
mod filling;
mod nonlinear;
mod program;
mod recursion;
mod sparsity;
mod stagewise;
#[cfg(test)]
mod tests;

pub use backend::{ProgramForm, QpBackend, QpSettings, QpStatus, StageSolution};
pub(crate) use nonlinear::{NonlinearProgram, NonlinearRow, NonlinearSlack};
pub use program::StageProgram;
pub(crate) use recursion::{Recursion, Shape};

use crate::controller::SolverEffort;
use crate::error::MpcError;
use crate::ocp::Ocp;
use crate::trajectory::PlannedTrajectory;
use crate::transcription::ShootingLinearization;
use assembly::Assembly;
use automatic::Automatic;
use clarabel::Clarabel;
use filling::LinearizationPoint;
use stagewise::Stagewise;

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

/// Violation of a hard constraint, in units of its scale, above which a program counts as relaxed.
const RELAXED: f64 = 1e-5;

/// The program: numbers and solver.
pub(crate) struct Qp {
    settings: QpSettings,
    assembly: Assembly,
    backend: Box<dyn QpBackend>,
    stage: StageSolution,
    proximal: f64,
    pub(crate) solution: QpSolution,
    effort: SolverEffort,
    /// Memory of [`Qp::residual`].
    slope: Vec<f64>,
}

impl Qp {
    /// Lays out the program for a horizon of `steps` intervals; `closure` marks the possible entries of ∂F/∂(x, u).
    pub(crate) fn new(ocp: &Ocp, steps: usize, closure: &[bool], settings: QpSettings) -> Self {
        Self::with_hessian(ocp, steps, closure, false, settings)
    }

    /// As [`Qp::new`], with the exact Hessian of the Lagrangian if `exact`, made convex; the linearization then holds the
    /// curvature of the flow.
    pub(crate) fn with_hessian(ocp: &Ocp, steps: usize, closure: &[bool], exact: bool, settings: QpSettings) -> Self {
        let assembly = Assembly::new(ocp, steps, closure, exact);
        let program = &assembly.program;
        let backend: Box<dyn QpBackend> = match settings.form {
            ProgramForm::Automatic => match Automatic::new(program, settings) {
                Some(automatic) => Box::new(automatic),
                None => Box::new(Clarabel::condensed(program, settings, automatic::clarabel_block(program))),
            },
            ProgramForm::Stagewise { block } => match Stagewise::new(program, settings, block.max(1)) {
                Some(stagewise) => Box::new(stagewise),
                None => Box::new(Clarabel::condensed(program, settings, automatic::clarabel_block(program))),
            },
            ProgramForm::Sparse => Box::new(Clarabel::sparse(program, settings)),
            ProgramForm::Condensed { block } => Box::new(Clarabel::condensed(program, settings, block)),
        };
        let (n, m) = (program.states, program.inputs);
        let stage = StageSolution {
            z: vec![0.0; program.variables()],
            multipliers: vec![0.0; steps * n],
            row_multipliers: Vec::with_capacity(program.right.len()),
            iterations: 0,
        };
        let solution = QpSolution {
            dx: vec![0.0; (steps + 1) * n],
            du: vec![0.0; steps * m],
            multipliers: vec![0.0; steps * n],
            iterations: 0,
        };
        let slope = vec![0.0; stage.z.len()];
        Self { settings, assembly, backend, stage, proximal: 0.0, solution, effort: SolverEffort::default(), slope }
    }

    /// What has been solved since the last call.
    pub(crate) fn take_effort(&mut self) -> SolverEffort {
        std::mem::take(&mut self.effort)
    }

    /// Number of intervals.
    pub(crate) fn steps(&self) -> usize {
        self.assembly.program.steps
    }

    /// The program as it was last filled, and its last solution.
    pub(crate) fn stage_program(&self) -> (&StageProgram, &[f64]) {
        (&self.assembly.program, &self.stage.z)
    }

    /// Residual of the conditions of optimality where the program was linearized, with the multipliers of its solution z: the slope of the
    /// Lagrangian there is −Hz, whose largest entry, in units of scales and objective, counts beside the largest defect.
    pub(crate) fn residual(&mut self) -> f64 {
        let (program, z, slope) = (&self.assembly.program, &self.stage.z, &mut self.slope);
        slope.fill(0.0);
        for ((i, j), h) in program.hessian() {
            slope[i] += h * z[j];
            if i != j {
                slope[j] += h * z[i];
            }
        }
        let slopes = slope.iter().zip(&program.scale).map(|(q, scale)| (q * scale).abs() / program.objective_scale);
        let n = program.states;
        let scale = |i: usize| program.scale[program.state(i / n + 1, i % n)];
        let defects = program.defect.iter().enumerate().map(|(i, c)| c.abs() / scale(i));
        slopes.chain(defects).fold(0.0, f64::max)
    }

    /// Sets the limits of the solutions that follow: interior-point iterations, and time in s.
    pub(crate) fn set_limits(&mut self, max_iterations: u32, time_limit: f64) -> Result<(), MpcError> {
        if (self.settings.max_iterations, self.settings.time_limit) == (max_iterations, time_limit) {
            return Ok(());
        }
        self.settings.max_iterations = max_iterations;
        self.settings.time_limit = time_limit;
        self.backend.set_limits(max_iterations, time_limit)
    }

    /// Sets the multipliers to zero.
    pub(crate) fn forget_multipliers(&mut self) {
        self.solution.multipliers.fill(0.0);
        self.stage.row_multipliers.clear();
    }

    /// Starts the next program from these multipliers of dynamics and rows.
    pub(crate) fn set_multipliers(&mut self, dynamics: &[f64], rows: &[f64]) {
        self.solution.multipliers.copy_from_slice(dynamics);
        self.stage.row_multipliers.clear();
        self.stage.row_multipliers.extend_from_slice(rows);
    }

    /// Takes over multipliers and limits of another program of the same problem.
    pub(crate) fn take_over(&mut self, other: &Self) -> Result<(), MpcError> {
        self.solution.multipliers.copy_from_slice(&other.solution.multipliers);
        self.stage.row_multipliers.clone_from(&other.stage.row_multipliers);
        self.set_limits(other.settings.max_iterations, other.settings.time_limit)
    }

    /// Moves the multipliers of the dynamics on by one interval; those of the rows are forgotten.
    pub(crate) fn shift_multipliers(&mut self) {
        let n = self.assembly.program.states;
        let y = &mut self.solution.multipliers;
        if y.len() > n {
            y.copy_within(n.., 0);
        }
        self.assembly.shift_rows(&mut self.stage.row_multipliers);
    }

    /// Fills in every number. `k0` is the grid point of the run at which the horizon starts, `proximal` the weight λ of the
    /// term dt·λ/2·Σ (change/trust)².
    pub(crate) fn assemble(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &PlannedTrajectory,
        lin: &ShootingLinearization,
        proximal: f64,
    ) {
        self.proximal = proximal;
        let point = LinearizationPoint { k0, trajectory, lin };
        self.assembly.fill(ocp, point, proximal, self.settings.hard_weight, &self.stage.row_multipliers);
        self.backend.load(&self.assembly.program, &lin.jacobian);
    }

    /// Replaces the numbers of the first interval alone, after its state has become known.
    pub(crate) fn update_first_interval(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trajectory: &PlannedTrajectory,
        lin: &ShootingLinearization,
    ) {
        self.assembly.fill_first(ocp, LinearizationPoint { k0, trajectory, lin }, self.proximal);
        self.backend.load_first(&self.assembly.program, &lin.jacobian);
    }

    /// Second-order correction of the program just solved: matrices and objective stay, but dynamics and constraints take the
    /// values at the end of the step in place of those that their linearizations promised there. `trial` is that end, `ends`
    /// the ends of its intervals.
    pub(crate) fn correct(
        &mut self,
        ocp: &mut Ocp,
        k0: usize,
        trial: &PlannedTrajectory,
        ends: &[f64],
        lin: &ShootingLinearization,
    ) {
        self.assembly.correct(ocp, LinearizationPoint { k0, trajectory: trial, lin }, ends, &self.stage.z);
        self.backend.load(&self.assembly.program, &lin.jacobian);
    }

    /// Solves; the step is in [`Qp::solution`] when the status says so.
    pub(crate) fn solve(&mut self) -> Result<QpStatus, MpcError> {
        let program = &self.assembly.program;
        let status = self.backend.solve(program, &mut self.stage)?;
        let (n, m) = (program.states, program.inputs);
        let (z, s) = (&self.stage.z, &mut self.solution);
        s.iterations = self.stage.iterations;
        self.effort += SolverEffort { programs: 1, interior_point_steps: s.iterations as usize };
        for k in 0..program.steps {
            let (x, u) = (program.state(k + 1, 0), program.input(k, 0));
            s.du[k * m..(k + 1) * m].copy_from_slice(&z[u..u + m]);
            s.dx[(k + 1) * n..(k + 2) * n].copy_from_slice(&z[x..x + n]);
        }
        for &(state, input) in self.assembly.moves.at(0) {
            s.dx[state] = s.du[input - n];
        }
        if status.is_usable() {
            s.multipliers.copy_from_slice(&self.stage.multipliers);
            if let Some(blocks) = &self.assembly.blocks {
                blocks.correct_multipliers(&s.dx, &mut s.multipliers, n);
            }
        }
        let relaxed = status == QpStatus::Solved && self.assembly.relaxation(z) > RELAXED;
        Ok(if relaxed { QpStatus::Relaxed } else { status })
    }
}
