//! How a diagnosis is made, and what it is doing.

use std::fmt;

use crate::{Effect, StudySettings};

/// How a diagnosis is made.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Windows, fixed parameters, iterations.
    pub study: StudySettings,
    /// Most causes that are named together.
    pub max_causes: usize,
    /// Probability of a false alarm, and of a false cause, that is accepted; corrected for the number of candidates.
    pub significance: f64,
    /// Relative change of a parameter that is calibration; more is `parameter_error`.
    pub tolerance: f64,
    /// Seed of what is resampled.
    pub seed: u64,
    /// Effects to try in addition to the library's.
    pub candidates: Vec<Effect>,
}

impl Default for Settings {
    /// At most three causes, significance 1 %, tolerance 7.5 %.
    fn default() -> Self {
        Self {
            study: StudySettings::default(),
            max_causes: 3,
            significance: 0.01,
            tolerance: 0.075,
            seed: 1,
            candidates: Vec::new(),
        }
    }
}

/// What a diagnosis is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Fitting the model's parameters.
    Refit,
    /// Putting candidates against the residual.
    Screen {
        /// Number of candidates.
        candidates: usize,
    },
    /// Fitting candidates exactly.
    Fit {
        /// How many causes the explanation will have.
        causes: usize,
    },
    /// Looking for other explanations.
    Rivals,
    /// Trying terms that have no name.
    Dictionary,
    /// Measuring what the extended model is worth.
    Gain,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stage::Refit => f.write_str("fitting the parameters"),
            Stage::Screen { candidates } => write!(f, "screening {candidates} candidates"),
            Stage::Fit { causes: 1 } => f.write_str("fitting one cause"),
            Stage::Fit { causes } => write!(f, "fitting {causes} causes"),
            Stage::Rivals => f.write_str("fitting rivals"),
            Stage::Dictionary => f.write_str("searching for unnamed terms"),
            Stage::Gain => f.write_str("measuring the gain"),
        }
    }
}
