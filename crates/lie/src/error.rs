//! Misuse and bad input.

use bracketry_symbolic::Undecided;

/// Why an analysis could not be made at all.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// There is nothing to analyse.
    #[error("the system has no states")]
    NoStates,
    /// A vector field or point of the wrong size.
    #[error("a vector field or point has {found} components where the system has {expected} states")]
    Dimension {
        /// Number of states.
        expected: usize,
        /// Components found.
        found: usize,
    },
    /// A point with the wrong number of inputs.
    #[error("the point gives {found} inputs where the system has {expected}")]
    Inputs {
        /// Number of inputs.
        expected: usize,
        /// Inputs found.
        found: usize,
    },
    /// The system is not affine in its inputs.
    #[error("{equation} is not affine in the inputs; make the system affine first")]
    NotAffine {
        /// Where.
        equation: String,
    },
    /// More switching functions than are expanded into modes.
    #[error("{switches} switching functions give too many modes")]
    Modes {
        /// Number of switching functions.
        switches: usize,
    },
    /// A constant that has no numerical value.
    #[error("{what} has no numerical value at the point")]
    NoValue {
        /// What.
        what: String,
    },
    /// A function that cannot be evaluated exactly.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}
