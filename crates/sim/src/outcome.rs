//! How a simulation ended, and the work it took.

use serde::{Deserialize, Serialize};

/// Why a simulation ended early.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum StopReason {
    /// A state, its derivative, a switching function, or the end time is not a finite number.
    NonFinite,
    /// The step became shorter than the resolution of time: the solution blows up, or is too stiff.
    StepTooSmall,
    /// More than `limit` events within `window` seconds.
    TooManyEvents {
        /// The cap on events.
        limit: usize,
        /// The window in seconds.
        window: f64,
    },
    /// More than `limit` steps.
    TooManySteps {
        /// The cap on steps.
        limit: usize,
    },
    /// No combination of sliding and sticking is consistent for the switches in the list, whose functions vanish together.
    NoConsistentMode {
        /// The switches.
        switches: Vec<usize>,
    },
    /// More switching functions vanish together than can be enumerated, and the active-set search found no mode.
    TooManySimultaneous {
        /// How many vanish.
        count: usize,
        /// The cap.
        limit: usize,
    },
    /// The system left what its model covers, such as a contact that opens.
    Departed {
        /// What happened.
        what: String,
    },
    /// The system announced a segment that does not end after it starts.
    EmptySegment,
    /// The flag of the settings was raised.
    Asked,
}

impl std::fmt::Display for StopReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Departed { what } => write!(f, "{what}"),
            Self::NonFinite => {
                write!(f, "a state, its derivative, a switching function, or the end time is not a finite number")
            }
            Self::StepTooSmall => write!(f, "the step became too small (blow-up or stiffness)"),
            Self::TooManyEvents { limit, window } => {
                write!(f, "more than {limit} events within {window} s (chattering)")
            }
            Self::TooManySteps { limit } => write!(f, "more than {limit} steps"),
            Self::NoConsistentMode { switches } => {
                write!(f, "no combination of sliding and sticking is consistent for the switches {switches:?}")
            }
            Self::TooManySimultaneous { count, limit } => {
                write!(f, "{count} switching functions vanish together, more than the {limit} that are enumerated")
            }
            Self::Asked => write!(f, "it was stopped on request"),
            Self::EmptySegment => write!(f, "an input segment does not end after it starts"),
        }
    }
}

/// How a simulation ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Outcome {
    /// It reached the end time.
    Finished,
    /// It stopped before.
    Stopped {
        /// Why.
        reason: StopReason,
        /// When, in seconds.
        t: f64,
        /// The last valid state.
        state: Vec<f64>,
    },
}

impl Outcome {
    /// Whether the end time was reached.
    pub fn is_finished(&self) -> bool {
        matches!(self, Outcome::Finished)
    }
}

/// Counts of work done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Located events.
    pub events: usize,
    /// Evaluations of the right-hand side.
    pub rhs: usize,
}
