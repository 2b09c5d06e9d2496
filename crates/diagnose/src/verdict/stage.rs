//! What a diagnosis is doing.

use std::fmt;

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
