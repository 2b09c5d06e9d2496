//! A solution, how it ended, and its log.

use super::settings::Hessian;
use crate::controller::SolverEffort;
use crate::qp::QpStatus;
use crate::trajectory::PlannedTrajectory;
use std::fmt;

/// How the iteration ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolveStatus {
    /// No step promises anything more.
    Converged,
    /// Converged, but a hard bound cannot be kept: largest violation in units of its state's scale.
    Infeasible {
        /// Largest violation.
        violation: f64,
    },
    /// The iteration limit came first.
    IterationLimit,
    /// No step lowers the merit, however short.
    Stalled,
    /// A quadratic program could not be solved, however strong the proximal term.
    QpFailed(QpStatus),
    /// Guess, initial state or dynamics gave a number that is not finite.
    NotANumber,
    /// The equations of an implicit integration step have no solution at the guess: give a better one or more substeps.
    IntegratorFailed,
}

/// One line of the log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iteration {
    /// Smoothing width, 0 if none was set.
    pub smoothing: f64,
    /// Cost and penalties before the step.
    pub objective: f64,
    /// Largest defect before the step, in units of the state scale.
    pub defect: f64,
    /// Fall of the merit that the program predicted.
    pub predicted: f64,
    /// What became of it, as a fraction.
    pub ratio: f64,
    /// Proximal weight.
    pub proximal: f64,
    /// Fraction of the program's step that was taken; 0 where it was rejected.
    pub fraction: f64,
    /// Whether this is a second-order correction of the program before.
    pub correction: bool,
    /// Status of the program.
    pub qp: QpStatus,
    /// Interior-point iterations.
    pub qp_iterations: u32,
}

/// A trajectory with the verdict on it.
#[derive(Clone, Debug)]
pub struct Solution {
    /// States and inputs.
    pub trajectory: PlannedTrajectory,
    /// How the iteration ended.
    pub status: SolveStatus,
    /// Stage and terminal cost, without penalties.
    pub cost: f64,
    /// Largest defect |F(x_k, u_k) − x_{k+1}|/scale.
    pub defect: f64,
    /// What is missing to every target, x_N − target.
    pub miss: Vec<f64>,
    /// Second derivatives of the last program: [`Hessian::GaussNewton`] or [`Hessian::Exact`].
    pub hessian: Hessian,
    /// Steps of the interior-point method, those of all its starts.
    pub interior_point_steps: usize,
    /// The log of the quadratic programs.
    pub iterations: Vec<Iteration>,
    /// Time taken, s.
    pub seconds: f64,
}

impl Solution {
    /// What was solved for it.
    pub fn effort(&self) -> SolverEffort {
        let in_programs: usize = self.iterations.iter().map(|i| i.qp_iterations as usize).sum();
        SolverEffort { programs: self.iterations.len(), interior_point_steps: self.interior_point_steps + in_programs }
    }
}

impl fmt::Display for SolveStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => write!(f, "converged"),
            Self::Infeasible { violation } => {
                write!(f, "infeasible: a hard bound is violated by {violation:.3e} scales")
            }
            Self::IterationLimit => write!(f, "stopped at the iteration limit"),
            Self::Stalled => write!(f, "stalled: no step decreases the merit function"),
            Self::QpFailed(s) => write!(f, "stopped: a quadratic program ended as {s:?}"),
            Self::NotANumber => write!(f, "stopped: a number is not finite"),
            Self::IntegratorFailed => write!(f, "stopped: an implicit integration step could not be solved"),
        }
    }
}
