//! States from measured columns alone, without a simulation.

use bracketry_symbolic::Node;
use bracketry_system::System;

use crate::record::Record;
use crate::signal::Quantity;

/// Where a state comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Origin {
    /// The measured column.
    pub(super) column: usize,
    /// How often it has to be differentiated for the state.
    pub(super) order: usize,
}

/// Where every state comes from: from its own column, from an output that is nothing but the state, or from the derivative of
/// a state whose equation is `q' = v`; `None` for one that no measured column gives.
pub(super) fn origins(system: &System, record: &Record) -> Vec<Option<Origin>> {
    let state_of = |e| match system.pool.node(e) {
        Node::Sym(s) => system.states.iter().position(|&x| x == s),
        _ => None,
    };
    let mut origins: Vec<Option<Origin>> = vec![None; system.states.len()];
    for (column, m) in record.measured.iter().enumerate() {
        let state = match m.quantity {
            Quantity::State(i) => Some(i),
            Quantity::Output(k) => system.outputs.get(k).and_then(|(_, e)| state_of(*e)),
        };
        if let Some(i) = state {
            origins[i] = origins[i].or(Some(Origin { column, order: 0 }));
        }
    }
    // As many rounds as a chain of derivatives can be long.
    for _ in 0..system.states.len() {
        for (i, e) in system.dynamics.iter().enumerate() {
            if let (Some(from), Some(v)) = (origins[i], state_of(*e)) {
                origins[v] = origins[v].or(Some(Origin { order: from.order + 1, ..from }));
            }
        }
    }
    origins
}
