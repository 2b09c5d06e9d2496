//! Functions of the state that a model names.

use bracketry_symbolic::{Expr, Pool};
use bracketry_system::System;

/// Whether an output depends on an input directly: it has relative degree zero, and nothing here applies.
pub(crate) fn fed_through(system: &System) -> bool {
    let outputs: Vec<Expr> = system.outputs.iter().map(|o| o.1).collect();
    system.pool.symbols_of(&outputs).iter().any(|s| system.inputs.contains(s))
}

/// The outputs of a model and those of its definitions that depend on the state and no input.
pub(crate) fn named_functions(system: &System) -> Vec<Expr> {
    let mut list: Vec<Expr> = Vec::new();
    if !fed_through(system) {
        list.extend(system.outputs.iter().map(|o| o.1));
    }
    for &(_, e) in &system.definitions {
        let symbols = system.pool.symbols_of(&[e]);
        if symbols.iter().any(|s| system.states.contains(s))
            && !symbols.iter().any(|s| system.inputs.contains(s))
            && !list.contains(&e)
        {
            list.push(e);
        }
    }
    list
}

/// `count` symbols that the pool does not use yet: prefix1, prefix2, …
pub(crate) fn fresh_symbols(pool: &mut Pool, prefix: &str, count: usize) -> Vec<Expr> {
    let taken = |prefix: &str| (1..=count).any(|i| pool.find_symbol(&format!("{prefix}{i}")).is_some());
    let mut prefix = prefix.to_owned();
    while taken(&prefix) {
        prefix.push('_');
    }
    (1..=count).map(|i| pool.var(&format!("{prefix}{i}"))).collect()
}
