//! The choice of a solver, program by program.

use super::backend::{QpBackend, QpSettings, QpStatus, StageSolution};
use super::clarabel::Clarabel;
use super::program::StageProgram;
use super::stagewise::Stagewise;
use crate::error::MpcError;

/// The stagewise method, and Clarabel for the programs that it does not solve.
pub(super) struct Automatic {
    settings: QpSettings,
    stagewise: Stagewise,
    /// Built when it is needed for the first time, with whether it has the present numbers.
    clarabel: Option<Clarabel>,
    loaded: bool,
}

/// Length of the blocks for Clarabel that is about the fastest.
pub(super) fn clarabel_block(program: &StageProgram) -> usize {
    program.states.div_ceil(program.inputs.max(1)).clamp(2, 5)
}

impl Automatic {
    /// `None` where the stagewise method does not apply.
    pub(super) fn new(program: &StageProgram, settings: QpSettings) -> Option<Self> {
        if settings.refine || settings.equilibrate {
            return None;
        }
        let stagewise = Stagewise::new(program, settings, Stagewise::best_length(program))?;
        Some(Self { settings, stagewise, clarabel: None, loaded: false })
    }
}

impl QpBackend for Automatic {
    fn load(&mut self, program: &StageProgram, flow: &[f64]) {
        self.loaded = false;
        self.stagewise.load(program, flow);
    }

    fn load_first(&mut self, program: &StageProgram, flow: &[f64]) {
        self.loaded = false;
        self.stagewise.load_first(program, flow);
    }

    fn set_limits(&mut self, max_iterations: u32, time_limit: f64) -> Result<(), MpcError> {
        self.settings.max_iterations = max_iterations;
        self.settings.time_limit = time_limit;
        if let Some(clarabel) = &mut self.clarabel {
            clarabel.set_limits(max_iterations, time_limit)?;
        }
        self.stagewise.set_limits(max_iterations, time_limit)
    }

    fn solve(&mut self, program: &StageProgram, solution: &mut StageSolution) -> Result<QpStatus, MpcError> {
        let status = self.stagewise.solve(program, solution)?;
        if status != QpStatus::Failed {
            return Ok(status);
        }
        let spent = solution.iterations;
        let block = clarabel_block(program);
        let clarabel = self.clarabel.get_or_insert_with(|| Clarabel::condensed(program, self.settings, block));
        if !std::mem::replace(&mut self.loaded, true) {
            clarabel.load(program, self.stagewise.flow());
        }
        let status = clarabel.solve(program, solution)?;
        solution.iterations += spent;
        Ok(status)
    }
}
