//! What a solver of stage programs does, and its settings.

use super::program::StageProgram;
use crate::error::MpcError;

/// The form in which the quadratic program is solved. The solution is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ProgramForm {
    /// [`ProgramForm::Stagewise`] where it applies, with Clarabel for the programs that it does not solve; else Clarabel with partial condensing.
    /// Blocks have the length that is about the fastest.
    #[default]
    Automatic,
    /// The Riccati recursion over blocks of this many intervals, for programs without norm constraints, terminal sets, move blocks,
    /// and scenario trees; those go to Clarabel.
    Stagewise {
        /// Number of intervals of a block.
        block: usize,
    },
    /// Multiple shooting as it stands: every state is a variable.
    Sparse,
    /// Partial condensing: states stay variables at every `block`-th grid point, the others are eliminated. A block of at
    /// least N intervals is full condensing: the inputs (and slacks) are the only variables.
    Condensed {
        /// Number of intervals between states that stay.
        block: usize,
    },
}

/// Settings of the interior-point solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QpSettings {
    /// Form in which the program is solved.
    pub form: ProgramForm,
    /// Largest number of interior-point iterations.
    pub max_iterations: u32,
    /// Absolute and relative tolerance on gap and feasibility.
    pub tolerance: f64,
    /// Whether the solver refines the solution of every linear system: slower, for tolerances below 1e-8.
    pub refine: bool,
    /// Whether the solver draws the sizes of variables and rows from the numbers of the first program, on top of those that
    /// the problem states (state scales, bounds and trusts of inputs). Without it, it does so where it fails otherwise.
    pub equilibrate: bool,
    /// Time after which the solver gives up, s.
    pub time_limit: f64,
    /// Weight, per unit of scale, on violations of hard constraints on states.
    pub hard_weight: f64,
}

impl Default for QpSettings {
    fn default() -> Self {
        Self {
            form: ProgramForm::default(),
            max_iterations: 100,
            tolerance: 1e-8,
            refine: false,
            equilibrate: false,
            time_limit: f64::INFINITY,
            hard_weight: 1e4,
        }
    }
}

impl QpSettings {
    /// Whether the settings are within their ranges.
    pub(super) fn check(&self) -> Result<(), MpcError> {
        let valid = self.tolerance > 0.0 && self.tolerance < 1.0 && self.time_limit > 0.0;
        if valid { Ok(()) } else { Err(self.out_of_range()) }
    }

    /// That they are not.
    pub(super) fn out_of_range(&self) -> MpcError {
        MpcError::Value {
            what: "the tolerance of the quadratic program".into(),
            value: self.tolerance,
            remedy: "give a tolerance between 0 and 1, and a positive time limit",
        }
    }
}

/// How the quadratic program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QpStatus {
    /// To full accuracy.
    Solved,
    /// To full accuracy, but the hard constraints contradict each other: the step is the one with the smallest violation.
    Relaxed,
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
        matches!(self, Self::Solved | Self::Relaxed | Self::Inaccurate)
    }
}

/// Solution of a [`StageProgram`].
#[derive(Clone, Debug, Default)]
pub struct StageSolution {
    /// All variables.
    pub z: Vec<f64>,
    /// Multipliers y of dx_{k+1} − A_k dx_k − B_k du_k − c_k = 0, N rows of n.
    pub multipliers: Vec<f64>,
    /// Multipliers of r − Rz ∈ K, one per row, in the dual cone; may stay empty: the curvature of constraints is then left out.
    pub row_multipliers: Vec<f64>,
    /// Number of iterations.
    pub iterations: u32,
}

/// A solver of stage programs. What may change between two loads are the numbers, never the structure.
pub trait QpBackend: Send {
    /// Takes in every number. `flow` holds the blocks (A_k, B_k), N blocks of n rows of n + m entries.
    fn load(&mut self, program: &StageProgram, flow: &[f64]);
    /// Takes in the numbers of the first interval (grid point 0), all others being those of the last
    /// [`QpBackend::load`].
    fn load_first(&mut self, program: &StageProgram, flow: &[f64]);
    /// Sets the limits of the solutions that follow: iterations, and time in s.
    ///
    /// # Errors
    /// If a limit is not positive.
    fn set_limits(&mut self, max_iterations: u32, time_limit: f64) -> Result<(), MpcError>;
    /// Solves what was loaded; `solution` has the right lengths.
    ///
    /// # Errors
    /// If the settings are out of range; everything else is a status.
    fn solve(&mut self, program: &StageProgram, solution: &mut StageSolution) -> Result<QpStatus, MpcError>;
}
