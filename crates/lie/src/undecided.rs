//! Why a question stays open.

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
    /// The system has very many states.
    #[error("not decided for more than {states} states, except for the dimensions of linear systems")]
    TooManyStates {
        /// States up to which all questions are asked.
        states: usize,
    },
    /// Ranks of too many or too large matrices.
    #[error("not decided because the ranks take more than {products:e} products")]
    TooMany {
        /// Products in eliminations that were allowed in all questions together.
        products: f64,
    },
}
