//! Misuse and bad input.

use bracketry_symbolic::Pool;

/// Why a question stays open.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Undecided {
    /// An exact test cannot tell.
    #[error(transparent)]
    Exact(#[from] bracketry_symbolic::Undecided),
    /// The expressions grew too large.
    #[error("not decided because the brackets take more than {nodes} nodes")]
    TooLarge {
        /// New nodes of the pool that were allowed.
        nodes: usize,
    },
}

/// Most new nodes of the pool in one closure under brackets.
const MAX_NODES: usize = 1_500_000;

/// Stops a computation that began when the pool had `first` nodes and has made too many.
pub(crate) fn check_size(pool: &Pool, first: usize) -> Result<(), Undecided> {
    if pool.len() > first + MAX_NODES { Err(Undecided::TooLarge { nodes: MAX_NODES }) } else { Ok(()) }
}

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
    /// A question that must be answered first stays open.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}
