//! How much memory questions may take, and giving it back.

use bracketry_symbolic::{Expr, Pool};

use crate::algebra::field::Field;
use crate::undecided::Undecided;

/// Most new nodes of the pool in one closure under brackets.
const MAX_NODES: usize = 400_000;

/// Most new nodes of the pool in all questions of an analysis together; the last may exceed it.
const MAX_ANALYSIS_NODES: usize = 1_000_000;

fn check(pool: &Pool, first: usize, coming: usize, nodes: usize) -> Result<(), Undecided> {
    if let Some(limit) = pool.reached_limit() {
        return Err(limit.into());
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
    if let Some(limit) = pool.reached_limit() {
        return Err(limit.into());
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
