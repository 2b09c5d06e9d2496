//! The figure of a simulation.

use super::columns::{input_columns, output_columns};
use super::friction::{friction_bands, friction_colors};
use super::text::ROUNDING;
use crate::curves::with_bounds;
use bracketry_plot::{Drawing, Panel, PlotError, Series, TimeSeries};
use bracketry_sim::{Scenario, ScenarioRun};
use bracketry_symbolic::Node;
use bracketry_system::System;

/// Plot panels of outputs are drawn up to this many.
const MAX_OUTPUT_PANELS: usize = 6;

/// States, inputs and outputs over time, with the modes of friction.
///
/// # Errors
/// [`PlotError`] for numbers that no axis holds.
pub fn figure(system: &System, scenario: &Scenario, run: &ScenarioRun) -> Result<Drawing, PlotError> {
    let mut chart =
        friction_colors(TimeSeries::new()).title(system.name.clone()).time_label(system.quantities.time_title("time"));
    // The unit stands behind all names of one quantity.
    let titled = |name: &str, others: &str| system.quantities.title(name).replacen(name, &format!("{name}{others}"), 1);
    let panel = |label: String, k: usize, rows: &[Vec<f64>]| {
        let values: Vec<f64> = rows.iter().map(|r| r[k]).collect();
        let series = Series::new("", run.times.clone(), values);
        let series = if system.period.is_some() { series.step() } else { series };
        Panel::new(label).rounding(ROUNDING).series(series)
    };
    // An output that is a state or an input has its name beside that one's, and no panel of its own.
    let inputs = input_columns(system, scenario);
    let drawn = |node: Node| {
        let mut symbols = system.states.iter().chain(inputs.iter().map(|(k, _)| &system.inputs[*k]));
        symbols.any(|s| node == Node::Sym(*s))
    };
    let (renamed, outputs): (Vec<_>, Vec<_>) =
        output_columns(system).into_iter().partition(|(k, _)| drawn(system.pool.node(system.outputs[*k].1)));
    let alias = |symbol| {
        let same = renamed.iter().filter(|(k, _)| system.pool.node(system.outputs[*k].1) == Node::Sym(symbol));
        same.fold(String::new(), |names, (_, name)| format!("{names} = {name}"))
    };
    for (k, name) in system.state_names().into_iter().enumerate() {
        let panel = panel(titled(&name, &alias(system.states[k])), k, &run.states);
        chart = chart.panel(friction_bands(panel, &run.simulation.trajectory, &run.switches, &name));
    }
    for (k, name) in inputs {
        let label = format!("input {}", titled(&name, &alias(system.inputs[k])));
        let panel = panel(label, k, &run.inputs);
        chart = chart.panel(match system.range_of_input(k) {
            Some(range) => with_bounds(panel, range),
            None => panel,
        });
    }
    if outputs.len() <= MAX_OUTPUT_PANELS {
        for (k, name) in outputs {
            chart = chart.panel(panel(titled(&name, ""), k, &run.outputs));
        }
    }
    chart.draw()
}
