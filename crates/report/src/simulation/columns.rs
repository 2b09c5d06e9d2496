//! Which quantities of a simulation have a column or a panel of their own.

use bracketry_sim::Scenario;
use bracketry_symbolic::Node;
use bracketry_system::System;

/// The outputs that have no column of their own yet, by index, with the names of their columns.
pub(super) fn output_columns(system: &System) -> Vec<(usize, String)> {
    let symbols = || system.states.iter().chain(&system.inputs);
    let mut columns = Vec::new();
    for (k, (name, e)) in system.outputs.iter().enumerate() {
        let same = symbols().any(|s| system.symbol_name(*s) == name && system.pool.node(*e) == Node::Sym(*s));
        let taken = name == "t" || symbols().any(|s| system.symbol_name(*s) == name);
        if !same {
            columns.push((k, if taken { format!("output {name}") } else { name.clone() }));
        }
    }
    columns
}

/// The inputs that something is known of, by index: not those of which only derivatives are given.
pub(super) fn input_columns(system: &System, scenario: &Scenario) -> Vec<(usize, String)> {
    let names = system.input_names().into_iter().enumerate();
    names.filter(|(_, name)| !scenario.inputs.only_derivatives(name)).collect()
}
