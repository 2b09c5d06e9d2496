//! Tables of a simulation: rows over time, and changes of mode.

use super::columns::{input_columns, output_columns};
use bracketry_sim::{FrictionMode, Scenario, ScenarioRun};
use bracketry_system::System;
use serde::Serialize;

/// A change of mode as a row of a table, or an object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Time in seconds.
    pub t: f64,
    /// The switching function.
    pub switch: String,
    /// The mode before: `+1`, `-1`, `slide` or `stick`.
    pub from: &'static str,
    /// The mode after.
    pub to: &'static str,
}

/// The changes of mode of a run, in order.
pub fn events(run: &ScenarioRun) -> Vec<Event> {
    let changes = run.simulation.trajectory.mode_changes().iter();
    let event = |e: &bracketry_sim::ModeChange| Event {
        t: e.t,
        switch: run.switches[e.switch].clone(),
        from: mode_name(e.from),
        to: mode_name(e.to),
    };
    changes.map(event).collect()
}

/// A mode in a word.
fn mode_name(mode: FrictionMode) -> &'static str {
    match mode {
        FrictionMode::Positive => "+1",
        FrictionMode::Negative => "-1",
        FrictionMode::Sliding => "slide",
        FrictionMode::Sticking => "stick",
    }
}

/// Times, states, inputs and those outputs that are none of these, as a table with its header.
pub fn table(system: &System, scenario: &Scenario, run: &ScenarioRun) -> (Vec<String>, Vec<Vec<f64>>) {
    let (inputs, outputs) = (input_columns(system, scenario), output_columns(system));
    let mut header = vec!["t".to_owned()];
    header.extend(system.state_names());
    header.extend(inputs.iter().chain(&outputs).map(|(_, name)| name.clone()));
    let values = run.states.iter().zip(run.inputs.iter().zip(&run.outputs));
    let rows = run.times.iter().zip(values).map(|(t, (x, (u, y)))| {
        let driven = inputs.iter().map(|(k, _)| u[*k]);
        let measured = outputs.iter().map(|(k, _)| y[*k]);
        std::iter::once(*t).chain(x.iter().copied()).chain(driven).chain(measured).collect()
    });
    (header, rows.collect())
}
