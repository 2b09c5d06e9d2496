//! Clarabel on the program with any of its states eliminated.

use super::backend::{QpBackend, QpSettings, QpStatus, StageSolution};
use super::condensing::Condensing;
use super::program::StageProgram;
use crate::error::MpcError;
use clarabel::algebra::CscMatrix;
use clarabel::solver::SupportedConeT::{NonnegativeConeT, SecondOrderConeT, ZeroConeT};
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT,
};

/// Mean curvature, per squared size of the variables, above which the objective is scaled down.
const STEEP: f64 = 1e3;

impl QpSettings {
    fn clarabel(self) -> Result<DefaultSettings<f64>, MpcError> {
        self.check()?;
        DefaultSettingsBuilder::default()
            .verbose(false)
            .max_iter(self.max_iterations)
            .time_limit(self.time_limit)
            .tol_gap_abs(self.tolerance)
            .tol_gap_rel(self.tolerance)
            .tol_feas(self.tolerance)
            // Data updates need the structure as given.
            .presolve_enable(false)
            .input_sparse_dropzeros(false)
            .equilibrate_enable(self.equilibrate)
            .iterative_refinement_enable(self.refine)
            .max_threads(1)
            .build()
            .map_err(|_| self.out_of_range())
    }
}

/// The solver with the matrices of the program as it sees it.
pub(super) struct Clarabel {
    condensing: Condensing,
    settings: QpSettings,
    p: CscMatrix<f64>,
    a: CscMatrix<f64>,
    q: Vec<f64>,
    b: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
    solver: Option<DefaultSolver<f64>>,
}

impl Clarabel {
    /// Every state stays a variable: multiple shooting as it stands.
    pub(super) fn sparse(program: &StageProgram, settings: QpSettings) -> Self {
        Self::new(program, settings, |_, _| false)
    }

    /// States stay variables at every `block`-th grid point within the horizon.
    pub(super) fn condensed(program: &StageProgram, settings: QpSettings, block: usize) -> Self {
        let steps = program.steps;
        Self::new(program, settings, |k, _| block > 1 && (k % block != 0 || k == steps))
    }

    fn new(program: &StageProgram, settings: QpSettings, eliminate: impl Fn(usize, usize) -> bool) -> Self {
        let (condensing, p, a) = Condensing::new(program, eliminate);
        let mut cones = vec![ZeroConeT(condensing.equalities()), NonnegativeConeT(program.nonnegative)];
        cones.extend(program.second_order.iter().map(|&d| SecondOrderConeT(d)));
        let (q, b) = (vec![0.0; p.n], vec![0.0; a.m]);
        Self { condensing, settings, p, a, q, b, cones, solver: None }
    }

    fn gather(&mut self) {
        self.condensing.gather(&mut self.p.nzval, &mut self.q, &mut self.a.nzval, &mut self.b);
    }

    /// A solver with the present numbers; `None` if it refuses the structure, which would be a defect of this module.
    fn build(&self, settings: QpSettings) -> Result<Option<DefaultSolver<f64>>, MpcError> {
        Ok(DefaultSolver::new(&self.p, &self.q, &self.a, &self.b, &self.cones, settings.clarabel()?).ok())
    }

    /// Factor of the objective within the solver, whose tolerances remain those of the objective as it is: a steep one would
    /// let the regularization of the linear systems vanish.
    fn objective_factor(&self) -> f64 {
        // The diagonal entry is the last of its column.
        let diagonal = self.p.colptr[1..].iter().map(|&end| self.p.nzval[end - 1]);
        (STEEP * self.p.n as f64 / diagonal.sum::<f64>()).min(1.0)
    }
}

impl QpBackend for Clarabel {
    fn load(&mut self, program: &StageProgram, flow: &[f64]) {
        self.condensing.load(program, flow);
        self.gather();
    }

    fn load_first(&mut self, program: &StageProgram, flow: &[f64]) {
        self.condensing.load_first(program, flow);
        self.gather();
    }

    fn set_limits(&mut self, max_iterations: u32, time_limit: f64) -> Result<(), MpcError> {
        self.settings.max_iterations = max_iterations;
        self.settings.time_limit = time_limit;
        let settings = self.settings.clarabel()?;
        if self.solver.as_mut().is_some_and(|s| s.update_settings(settings).is_err()) {
            // The next solution builds a new solver with them.
            self.solver = None;
        }
        Ok(())
    }

    fn solve(&mut self, program: &StageProgram, solution: &mut StageSolution) -> Result<QpStatus, MpcError> {
        let finite = |v: &[f64]| v.iter().all(|x| x.is_finite());
        if !(finite(&self.p.nzval) && finite(&self.q) && finite(&self.a.nzval) && finite(&self.b)) {
            return Ok(QpStatus::NotANumber);
        }
        if self.p.n == 0 {
            // Without inputs, every state follows from the first one, and the solver takes no empty program.
            solution.iterations = 0;
            self.condensing.recover(&[], &vec![0.0; self.b.len()], solution, program.states);
            return Ok(QpStatus::Solved);
        }
        if self.solver.is_none() {
            self.solver = self.build(self.settings)?;
        }
        let factor = self.objective_factor();
        let Some(solver) = self.solver.as_mut() else { return Ok(QpStatus::Failed) };
        if !self.settings.equilibrate {
            solver.data.equilibration.c = factor;
        }
        if solver.update_data(&self.p.nzval, &self.q, &self.a.nzval, &self.b).is_err() {
            return Ok(QpStatus::Failed);
        }
        solver.solve();
        let mut status = status_of(solver);
        solution.iterations = solver.solution.iterations;
        let mut equilibrated = None;
        if status == QpStatus::Failed && !self.settings.equilibrate {
            // Sizes that do not fit the problem: once more, with sizes drawn from the numbers.
            equilibrated = self.build(QpSettings { equilibrate: true, ..self.settings })?;
            if let Some(s) = &mut equilibrated {
                s.solve();
                status = status_of(s);
                solution.iterations += s.solution.iterations;
            }
        }
        let Some(solver) = equilibrated.as_ref().or(self.solver.as_ref()) else { return Ok(QpStatus::Failed) };
        let (x, z) = (&solver.solution.x, &solver.solution.z);
        self.condensing.recover(x, z, solution, program.states);
        let whole = finite(&solution.z);
        Ok(if status.is_usable() && !whole { QpStatus::Failed } else { status })
    }
}

fn status_of(solver: &DefaultSolver<f64>) -> QpStatus {
    match solver.solution.status {
        SolverStatus::Solved => QpStatus::Solved,
        SolverStatus::AlmostSolved => QpStatus::Inaccurate,
        SolverStatus::MaxIterations | SolverStatus::MaxTime => QpStatus::Limit,
        _ => QpStatus::Failed,
    }
}
