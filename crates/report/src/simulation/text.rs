//! The text of a simulation.

use super::breakdown::stop;
use bracketry_sim::{SampledScenario, ScenarioRun};
use bracketry_system::{ClosestApproach, System, counted, readable};

/// Rounding on a sticking surface, which is not worth an axis of its own.
pub(super) const ROUNDING: f64 = 1e-13;

/// The report of a run of `given` on `system`.
pub fn text(system: &System, given: &SampledScenario, run: &ScenarioRun) -> String {
    let mut lines = vec![format!("{}: {}", system.name, done(system, run))];
    lines.extend(remarks(system, given, run).iter().map(|sentence| format!("  {sentence}")));
    let names = system.state_names();
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max(10);
    let states = names.iter().zip(run.simulation.trajectory.final_state());
    lines.extend(states.map(|(name, value)| format!("  {name:>width$} = {}", readable(*value))));
    lines.extend(stop(system, run));
    lines.join("\n") + "\n"
}

/// How much was simulated.
pub(super) fn done(system: &System, run: &ScenarioRun) -> String {
    let trajectory = &run.simulation.trajectory;
    format!(
        "{} simulated in {}, {}",
        system.quantities.time_unit.text(readable(trajectory.end() - trajectory.start())),
        counted(run.simulation.statistics.steps, "step", "steps"),
        counted(trajectory.mode_changes().len(), "mode change", "mode changes")
    )
}

/// What is to be said of inputs, ranges, and the model, a sentence each.
pub(super) fn remarks(system: &System, given: &SampledScenario, run: &ScenarioRun) -> Vec<String> {
    let at_zero = given.held_at_zero.iter();
    let mut lines: Vec<String> = at_zero.map(|name| format!("the input `{name}` is not driven: it is zero")).collect();
    lines.extend(run.impulses_left_out.iter().map(|(input, order)| {
        format!("warning: `{input}` jumps or has kinks: impulses of der({input},{order}) are neglected")
    }));
    lines.extend(beyond_ranges(system, run).iter().map(|sentence| format!("warning: {sentence}")));
    lines.extend(notes(system, run).iter().map(|sentence| format!("note: {sentence}")));
    let ignored = given.ignored.iter();
    lines.extend(ignored.map(|name| format!("column `{name}` is not an input that the model uses and was ignored")));
    lines
}

/// What is to be said beside the figures: what was eliminated from the model, and where it is nearly singular.
pub(super) fn notes(system: &System, run: &ScenarioRun) -> Vec<String> {
    system.eliminated.iter().map(ToString::to_string).chain(singular(system, run)).collect()
}

/// Where directions that are no dry friction are used of vectors that nearly vanish.
fn singular(system: &System, run: &ScenarioRun) -> Vec<String> {
    let rows = run.states.iter().map(Vec::as_slice).zip(run.inputs.iter().map(Vec::as_slice));
    let sentence = |near: ClosestApproach| {
        format!(
            "the direction of ({}) is used where its length is {} (t = {}); it is smooth except at length 0; write \
             unit(…) for friction",
            near.name,
            readable(near.length),
            system.quantities.time_unit.text(readable(run.times[near.row]))
        )
    };
    system.closest_approaches(rows).into_iter().map(sentence).collect()
}

/// What the model says an input cannot do, and it does.
fn beyond_ranges(system: &System, run: &ScenarioRun) -> Vec<String> {
    let mut sentences = Vec::new();
    for range in &system.input_ranges {
        let Some(k) = system.inputs.iter().position(|i| *i == range.input) else { continue };
        let values = run.inputs.iter().map(|u| u[k]);
        let bounds = [(&range.min, "below", -1.0), (&range.max, "above", 1.0)];
        for (bound, side, sign) in bounds.iter().filter_map(|(b, side, sign)| Some((b.as_ref()?, side, sign))) {
            let bound = bound.to_f64().value();
            let farthest = values.clone().max_by(|a, b| (sign * a).total_cmp(&(sign * b)));
            if let Some(farthest) = farthest.filter(|v| sign * (v - bound) > ROUNDING * bound.abs().max(1.0)) {
                sentences.push(format!(
                    "`{}` goes to {}, {side} the {} of its range in the model",
                    system.symbol_name(range.input),
                    readable(farthest),
                    readable(bound)
                ));
            }
        }
    }
    sentences
}
