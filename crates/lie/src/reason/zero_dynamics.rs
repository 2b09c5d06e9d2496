//! Why there are no zero dynamics.

use bracketry_symbolic::Function;

use crate::undecided::Undecided;

/// Why there are no zero dynamics in closed form.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoZeroDynamics {
    /// A function on the set that must vanish was not solved for a state.
    #[error("{constraint} = 0 was not solved for a state")]
    Unsolved {
        /// The function.
        constraint: Function,
    },
    /// Several functions may vanish, and the point does not tell which.
    #[error("{constraint} = 0 has several branches; a point on one of them would select it")]
    Branches {
        /// The product.
        constraint: Function,
    },
    /// A derivative of an output cannot vanish.
    #[error("no input holds the outputs there: {derivative} would have to vanish")]
    Empty {
        /// The derivative.
        derivative: Function,
    },
    /// An exact test cannot tell.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

impl From<bracketry_symbolic::Undecided> for NoZeroDynamics {
    fn from(why: bracketry_symbolic::Undecided) -> Self {
        NoZeroDynamics::Undecided(why.into())
    }
}
