//! Methods of control, each with its settings.

use crate::sqp::Hessian;
use serde::Serialize;

/// How the closed loop is controlled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// The one of the others that the problem needs. It is chosen once, when a controller is started.
    Automatic {
        /// When a solution is converged, where the method has one.
        convergence: Convergence,
    },
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
            Self::Automatic { convergence } | Self::Sqp { convergence, .. } | Self::Plan { convergence, .. } => {
                convergence
            }
            Self::Rti { .. } | Self::StickSlip { .. } => Convergence::default(),
        }
    }

    /// Widths that replace `sign` in the controller's model where the problem gives none, from wide to narrow.
    pub(super) fn widths(&self) -> &'static [f64] {
        match self {
            Self::Automatic { .. } | Self::Rti { .. } | Self::Sqp { .. } => &[0.01],
            Self::Plan { .. } => &[0.1, 0.03, 0.01, 0.003],
            Self::StickSlip { .. } => &[0.1, 0.01],
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

/// Why the loop is closed by its method.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum MethodReason {
    /// The problem names it.
    Given,
    /// The problem has a setting of this method alone.
    Setting {
        /// The key.
        key: String,
    },
    /// Dry friction is in reach of the plan.
    Friction {
        /// What vanishes or changes its sign.
        names: Vec<String>,
    },
    /// The run ends with the horizon, at whose end there are targets: a horizon that moves on would not arrive.
    Targets,
    /// The run ends with the horizon, and the cost counts there alone: a horizon that moves on would never pay it.
    TerminalCost,
    /// The end time or a parameter is free: a plan decides on it.
    Free,
    /// More programs hardly change the plan of the first one.
    Settled {
        /// Largest change, as a share of the cost or of what an input may change.
        change: f64,
    },
    /// More programs change the plan of the first one.
    NotSettled {
        /// Largest change, as a share of the cost or of what an input may change; none where one of the plans fails.
        #[serde(skip_serializing_if = "Option::is_none")]
        change: Option<f64>,
    },
    /// More programs change the plan of the first one, but do not converge either.
    NotConverging,
}

impl Method {
    /// Its name in problem files, where [`Method::Automatic`] is the method of those that name none.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Automatic { .. } => "automatic",
            Self::Rti { .. } => "rti",
            Self::Sqp { .. } => "sqp",
            Self::Plan { .. } => "plan",
            Self::StickSlip { .. } => "stick-slip",
        }
    }
}
