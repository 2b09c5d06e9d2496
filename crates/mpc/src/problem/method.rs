//! Methods of control, each with its settings.

use crate::sqp::Hessian;

/// How the closed loop is controlled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// Real-time iteration: one quadratic program per sample, receding horizon.
    Rti {
        /// Programs solved before the first input is applied.
        initial_iterations: usize,
        /// The iteration at every sample.
        feedback: Feedback,
    },
    /// Sequential quadratic programming to convergence at every sample, receding horizon.
    Sqp {
        /// When a solution is converged.
        convergence: Convergence,
        /// Whole steps that look for a better first solution where friction is smoothed.
        first: Feedback,
    },
    /// A plan solved to convergence first, then real-time iteration on what is left of the horizon.
    Plan {
        /// When the plan is converged.
        convergence: Convergence,
        /// Fraction by which the plan's bounds are tightened, to leave the feedback room.
        margin: f64,
        /// The iteration that tracks the plan.
        feedback: Feedback,
    },
    /// As [`Method::Sqp`], on the exact stick–slip flow in place of smoothed friction.
    StickSlip {
        /// Largest number of programs per sample.
        iterations: usize,
    },
}

impl Method {
    /// The settings of the method's converged solution, else the default ones.
    pub fn convergence(&self) -> Convergence {
        match *self {
            Self::Sqp { convergence, .. } | Self::Plan { convergence, .. } => convergence,
            Self::Rti { .. } | Self::StickSlip { .. } => Convergence::default(),
        }
    }

    /// The margin of [`Method::Plan`]; 0 for the others.
    pub(super) fn margin(&self) -> f64 {
        if let Self::Plan { margin, .. } = *self { margin } else { 0.0 }
    }
}

/// Settings of a solution by sequential quadratic programming, as [`SqpSettings`](crate::SqpSettings) has them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Convergence {
    /// Largest number of programs at each smoothing width.
    pub max_iterations: usize,
    /// The solution is accepted when a step promises less than this fraction of the merit.
    pub tolerance: f64,
    /// Largest defect, in units of the state scale, of an accepted solution.
    pub defect_tolerance: f64,
    /// Second derivatives of the programs.
    pub hessian: Hessian,
}

impl Default for Convergence {
    fn default() -> Self {
        Self { max_iterations: 100, tolerance: 1e-8, defect_tolerance: 1e-6, hessian: Hessian::default() }
    }
}

/// Settings of the programs at a sample, as [`RtiSettings`](crate::RtiSettings) has them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// Largest number of programs per sample.
    pub iterations: usize,
    /// Weight of the proximal term.
    pub proximal: f64,
    /// Whether steps are checked against the merit function.
    pub guarded: bool,
    /// Largest time of a sample, s.
    pub time_limit: f64,
}

impl Default for Feedback {
    fn default() -> Self {
        Self { iterations: 1, proximal: 0.0, guarded: false, time_limit: f64::INFINITY }
    }
}
