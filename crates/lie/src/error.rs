//! Misuse and bad input.

use bracketry_symbolic::{Expr, Pool};

use crate::fields::Field;
use crate::word::WordError;

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
    /// The pool's [`StopFlag`](bracketry_symbolic::StopFlag) was raised.
    #[error("not decided because the analysis was stopped")]
    Stopped,
    /// Ranks of too many or too large matrices.
    #[error("not decided because the ranks take more than {products:e} products")]
    TooMany {
        /// Products in eliminations that were allowed in all questions together.
        products: f64,
    },
}

/// Most new nodes of the pool in one closure under brackets.
const MAX_NODES: usize = 400_000;

/// Most new nodes of the pool in all questions of an analysis together; the last may exceed it.
const MAX_ANALYSIS_NODES: usize = 1_000_000;

fn check(pool: &Pool, first: usize, coming: usize, nodes: usize) -> Result<(), Undecided> {
    if pool.stop_flag().is_raised() {
        return Err(Undecided::Stopped);
    }
    if pool.len() + coming > first + nodes { Err(Undecided::TooLarge { nodes }) } else { Ok(()) }
}

/// Stops a computation that began when the pool had `first` nodes and has made too many.
pub(crate) fn check_size(pool: &Pool, first: usize) -> Result<(), Undecided> {
    check(pool, first, 0, MAX_NODES)
}

/// The same before derivatives of `roots` by `directions` variables are formed, which takes at
/// least about as many nodes as they have.
pub(crate) fn check_growth(pool: &Pool, first: usize, roots: [&[Expr]; 2], directions: usize) -> Result<(), Undecided> {
    check_size(pool, first)?;
    // They have no more nodes than there are.
    if check(pool, first, pool.len() * directions, MAX_NODES).is_ok() {
        return Ok(());
    }
    check(pool, first, pool.reachable(&roots.concat()).len() * directions, MAX_NODES)
}

/// Stops an analysis that began when the pool had made `first` nodes, between two questions. Nodes that were
/// freed since count as well.
pub(crate) fn check_analysis(pool: &Pool, first: usize) -> Result<(), Undecided> {
    if pool.stop_flag().is_raised() {
        return Err(Undecided::Stopped);
    }
    let nodes = MAX_ANALYSIS_NODES;
    if pool.made() > first + nodes { Err(Undecided::TooLarge { nodes }) } else { Ok(()) }
}

/// Fewer nodes are not worth the derivatives that are forgotten with them.
const WORTH_FREEING: usize = 20_000;

/// Frees what a question left in the pool, which had `first` nodes before, but for its answer. Nobody else
/// may hold an expression that was made since.
pub(crate) fn release(pool: &mut Pool, first: usize, answer: &mut [Field]) {
    if pool.len() < first + WORTH_FREEING {
        return;
    }
    let mut roots = answer.concat();
    pool.collect(first, &mut roots);
    let mut moved = roots.into_iter();
    for field in answer {
        for (component, new) in field.iter_mut().zip(&mut moved) {
            *component = new;
        }
    }
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
    /// The range of an input is told that does not exist.
    #[error("there is no input {name} that could have a range")]
    UnknownInput {
        /// The name.
        name: String,
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
    /// Text that should be a bracket of the system's fields.
    #[error(transparent)]
    Bracket(#[from] WordError),
    /// A function that was asked for cannot be read.
    #[error("`{text}`: {problem}")]
    Function {
        /// The text.
        text: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A question that must be answered first stays open.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}
