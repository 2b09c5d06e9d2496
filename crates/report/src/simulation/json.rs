//! The JSON object of a simulation.

use super::breakdown::stop;
use super::table::{Event, events};
use super::text::notes;
use bracketry_sim::{SampledScenario, ScenarioRun, Statistics};
use bracketry_system::System;
use serde::Serialize;
use serde_json::{Map, Value};

#[derive(Serialize)]
struct Simulation<'a> {
    model: &'a str,
    /// s.
    t_final: f64,
    /// By name, in the order of the model.
    x_final: Map<String, Value>,
    finished: bool,
    stopped: Option<String>,
    events: Vec<Event>,
    steps: usize,
    effort: Statistics,
    ignored_columns: &'a [String],
    inputs_at_zero: &'a [String],
    impulses_left_out: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
}

/// The object of a run of `given` on `system`, in the order of its keys.
pub fn json<'a>(system: &'a System, given: &'a SampledScenario, run: &ScenarioRun) -> impl Serialize + 'a {
    let trajectory = &run.simulation.trajectory;
    let last = trajectory.final_state().iter().map(|v| Value::from(*v));
    Simulation {
        model: &system.name,
        t_final: trajectory.end(),
        x_final: system.state_names().into_iter().zip(last).collect(),
        finished: run.simulation.outcome.is_finished(),
        stopped: stop(system, run),
        events: events(run),
        steps: run.simulation.statistics.steps,
        effort: run.simulation.statistics,
        ignored_columns: &given.ignored,
        inputs_at_zero: &given.held_at_zero,
        impulses_left_out: run.impulses_left_out.iter().map(|(n, order)| format!("der({n},{order})")).collect(),
        notes: notes(system, run),
    }
}
