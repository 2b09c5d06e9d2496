//! A simulation as a page.

use bracketry_sim::{SampledScenario, ScenarioRun};
use bracketry_system::{System, readable};

use super::breakdown::stop;
use super::table::events;
use super::text::{done, remarks};
use crate::html::{self, Chapter, Figure, Page, escaped, facts, folded, list, paragraph, table};

/// Changes of mode that a page lists; the table beside it has all of them.
const MOST_EVENTS: usize = 200;

/// The run of `given` on `system` as an HTML page with these figures, and links to these files beside it.
pub fn page(
    system: &System,
    given: &SampledScenario,
    run: &ScenarioRun,
    figures: &[Figure],
    files: &[(String, String)],
) -> String {
    let done = done(system, run);
    let verdict = stop(system, run).map_or_else(|| format!("{done}."), |why| format!("{}. {done}.", why.trim()));
    let lead = format!("<p class=\"verdict\">{}</p>\n", escaped(&verdict)) + &html::figures(figures);
    let end = run.simulation.trajectory.final_state();
    let states = system.state_names().into_iter().zip(end);
    let states = states.map(|(name, value)| (system.quantities.title(&name), readable(*value)));
    let mut chapters = vec![Chapter::new("State at the end", facts("State at the end", states))];
    let remarks = remarks(system, given, run);
    if !remarks.is_empty() {
        chapters.push(Chapter::new("Notes", list(&remarks)));
    }
    chapters.extend(mode_changes(system, run));
    chapters.push(Chapter::model("Model", system));
    chapters.push(Chapter::files(files));
    Page::new(format!("Simulation of {}", system.name), lead).chapters(chapters).html()
}

/// The changes of mode; none without any.
fn mode_changes(system: &System, run: &ScenarioRun) -> Option<Chapter> {
    let events = events(run);
    if events.is_empty() {
        return None;
    }
    let time = escaped(&system.quantities.time_title("time"));
    let row = |e: &super::Event| vec![readable(e.t), escaped(&e.switch), e.from.to_owned(), e.to.to_owned()];
    let rows =
        table("Mode changes", &[&time, "switching function", "from", "to"], events.iter().take(MOST_EVENTS).map(row));
    let left_out = events.len().saturating_sub(MOST_EVENTS);
    let more = match left_out {
        0 => String::new(),
        n => paragraph(&format!("The table of all mode changes has {n} more.")),
    };
    Some(Chapter::new("Mode changes", folded("When the sign of a switching function changes", &(rows + &more))))
}
