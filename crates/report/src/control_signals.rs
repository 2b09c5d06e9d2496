//! Signals of a closed loop beside states and inputs: references and named constraints, as columns and panels.

use bracketry_mpc::problem::Scheduled;
use bracketry_mpc::{ControlProblem, Controlled};
use bracketry_plot::{Dash, Panel, Series};

/// Panels of constraints beyond which a figure is not read any more; all of them are in the table.
const MOST_PANELS: usize = 6;

/// Names and values, one per time, of the references, then of the constraints that have names, and of limits that change.
pub(crate) fn columns(problem: &ControlProblem, controlled: &Controlled, taken: &[String]) -> Vec<(String, Vec<f64>)> {
    let t = &controlled.run.closed_loop.t;
    let mut columns: Vec<(String, Vec<f64>)> = Vec::new();
    let mut add = |name: String, what: &str, values: Vec<f64>| {
        let known = |n: &String| taken.contains(n) || columns.iter().any(|c| c.0 == *n);
        // No two columns have one name.
        let name = if known(&name) { format!("{what} {name}") } else { name };
        columns.push((name, values));
    };
    for r in references(problem) {
        add(r.name.clone(), "reference", t.iter().map(|t| r.at(*t)).collect());
    }
    for c in controlled.run.constraints.iter().filter(|c| !c.name.is_empty()) {
        add(c.name.clone(), "constraint", c.values.clone());
        if c.max.iter().any(|end| *end != c.max[0]) {
            add(format!("{} max", c.name), "constraint", c.max.clone());
        }
    }
    columns
}

/// The panel of a state or input with the references that it follows.
pub(crate) fn with_references(mut panel: Panel, problem: &ControlProblem, t: &[f64], name: &str) -> Panel {
    for r in references(problem) {
        if problem.references.iter().any(|u| u.name == r.name && u.tracked_by.as_deref() == Some(name)) {
            panel = panel.series(reference(r, t));
        }
    }
    panel
}

/// Whether a state or input follows a reference.
pub(crate) fn is_tracking(problem: &ControlProblem, name: &str) -> bool {
    problem.references.iter().any(|r| r.tracked_by.as_deref() == Some(name))
}

/// A panel for every reference that no state and no input follows, but which something uses, and for every named constraint.
pub(crate) fn panels(problem: &ControlProblem, controlled: &Controlled) -> Vec<Panel> {
    let t = &controlled.run.closed_loop.t;
    let free = |r: &&Scheduled| problem.references.iter().any(|u| u.name == r.name && u.used && u.tracked_by.is_none());
    let mut panels: Vec<Panel> = references(problem)
        .filter(free)
        .map(|r| Panel::new(format!("reference {}", r.name)).series(reference(r, t)))
        .collect();
    for c in controlled.run.constraints.iter().filter(|c| !c.name.is_empty()).take(MOST_PANELS) {
        let mut panel = Panel::new(c.name.clone()).series(Series::new("", t.clone(), c.values.clone()));
        for ends in [&c.min, &c.max] {
            if ends.iter().any(|end| *end != ends[0]) {
                panel = panel.series(Series::new("limit", t.clone(), ends.clone()).dash(Dash::Dotted));
            } else if let Some(end) = ends.first().filter(|end| end.is_finite()) {
                panel = panel.bound(*end);
            }
        }
        panels.push(panel);
    }
    panels
}

/// The references, and after them those of their derivatives that are used.
fn references(problem: &ControlProblem) -> impl Iterator<Item = &Scheduled> {
    problem.schedule.references.iter()
}

fn reference(r: &Scheduled, t: &[f64]) -> Series {
    let values: Vec<f64> = t.iter().map(|t| r.at(*t)).collect();
    Series::new(r.name.clone(), t.to_vec(), values).dash(Dash::Dashed)
}
