//! Closed loops as text, table and figure.

use std::fmt::Write as _;

use bracketry_mpc::closed_loop::{LateSamples, PlantEquations, PlantStopped};
use bracketry_mpc::ocp::BoundSide;
use bracketry_mpc::problem::{ClosedLoopReport, FoundValues, MethodReason};
use bracketry_mpc::sqp::Hessian;
use bracketry_mpc::{ControlError, ControlProblem, Controlled, MpcError, Ocp, PlannedTrajectory};
use bracketry_plot::{Dash, Drawing, Panel, PlotError, Series, TimeSeries};
use bracketry_sim::Breakdown;
use bracketry_system::{TimeUnit, counted, readable};

use crate::control_signals::{columns, is_tracking, panels, with_references};
use crate::curves::{drawn_times, with_bounds};
use crate::html::{self, Chapter, Figure, Page, escaped};
use crate::simulation::{self, friction_bands, friction_colors};

/// The figures of a closed loop, one to a line.
pub fn text(report: &ClosedLoopReport) -> String {
    let width = report.x_final.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max(8);
    let line = |(what, said): (String, String)| {
        let what = match what.strip_prefix(FINAL) {
            Some(name) => format!("{FINAL}{name:<width$}"),
            None => what,
        };
        format!("{what:<14} {said}\n")
    };
    facts(report).into_iter().map(line).collect()
}

/// What the name of the last value of a state starts with.
const FINAL: &str = "final ";

/// What is to be said of a closed loop: what, and its value.
fn facts(report: &ClosedLoopReport) -> Vec<(String, String)> {
    let mut facts = Vec::new();
    let mut add = |what: &str, said: String| facts.push((what.to_owned(), said));
    add("method", format!("{}: {}", report.method, why(&report.method_reason)));
    if let Some(p) = &report.plan {
        let programs = effort(p.interior_point_steps, p.programs);
        let exact = if p.hessian == Hessian::Exact { ", the last with the exact Hessian," } else { "" };
        add("plan", format!("{}, {programs}{exact} in {:.2} s", p.status, p.seconds));
    }
    if let Some(found) = &report.found {
        add("found", free_values(found, report.time_unit));
    }
    for m in report.chance.iter().flat_map(|c| &c.margins) {
        let (first, last) = (readable(m.first), readable(m.last));
        let said = format!("{first} at the start, {last} at the end, for a probability of {}", m.probability);
        add(&format!("margin {}", m.name), said);
    }
    if let Some(r) = &report.rounding {
        let names = r.inputs.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        let (relaxed, rounded) = (readable(r.relaxed_cost), readable(r.rounded_cost));
        add(
            "rounding",
            format!("first plan costs {relaxed} relaxed, {rounded} with {names} rounded to allowed values"),
        );
    }
    if let Some(tree) = &report.scenarios {
        let branches = counted(tree.branches, "branch", "branches");
        let violation = tree
            .predicted_violation
            .map_or_else(String::new, |v| format!(", largest predicted violation in any branch: {}", readable(v)));
        add("scenarios", branches + &violation);
    }
    add("cost", cost(report));
    let c = &report.status;
    add(
        "samples",
        format!(
            "{}: {} solved, {} inaccurate, {} infeasible, {} fallback, {} after the end of the plan",
            report.steps, c.solved, c.inaccurate, c.infeasible, c.fallback, c.played_out
        ),
    );
    let s = &report.solve_ms;
    let period = if report.time_unit.is_second() {
        format!("{} ms", readable(report.period_ms))
    } else {
        report.time_unit.text(readable(report.period))
    };
    add(
        "step time",
        format!(
            "{:.2} ms median, {:.2} ms 99th percentile, {:.2} ms longest; sampling period {period}",
            s.median, s.p99, s.max
        ),
    );
    add("bounds", bounds(report));
    for r in &report.input_ranges {
        let ends = [(r.min, "at or above "), (r.max, "at or below ")];
        let ends = ends.into_iter().filter_map(|(end, word)| Some(format!("{word}{}", readable(end?))));
        let ends = ends.collect::<Vec<_>>().join(" and ");
        add(&format!("input {}", r.input), format!("kept {ends} by its range in the model"));
    }
    for (name, v) in report.x_final.iter() {
        let off =
            report.miss.get(name).map_or_else(String::new, |e| format!(", off its target by {}", readable(e.abs())));
        add(&format!("{FINAL}{name}"), format!("{}{off}", readable(*v)));
    }
    for note in &report.notes {
        add("note", note.to_string());
    }
    if let Some(said) = late(&report.late, report.period_ms) {
        add("note", said);
    }
    facts
}

/// The values that were free, and what it took to find them.
fn free_values(found: &FoundValues, time: TimeUnit) -> String {
    let unit = match time {
        TimeUnit::Dimensionless => String::new(),
        unit => format!(" {}", unit.symbol()),
    };
    let end_time = found.end_time.iter().map(|t| ("end time", *t, unit.as_str()));
    let parameters = found.parameters.iter().map(|(name, v)| (name.as_str(), *v, ""));
    let starts = found.initial_states.iter().map(|(name, v)| (name.as_str(), *v, " at the start"));
    let values =
        end_time.chain(parameters).chain(starts).map(|(name, v, unit)| format!("{name} {}{unit}", readable(v)));
    let programs = effort(found.interior_point_steps, found.programs);
    format!("{}: {}, {programs} in {:.2} s", values.collect::<Vec<_>>().join(", "), found.status, found.seconds)
}

fn cost(report: &ClosedLoopReport) -> String {
    let (cost, predicted) = (readable(report.closed_loop_cost), readable(report.open_loop_cost));
    let mut out = format!("{cost} in closed loop, {predicted} predicted");
    if report.open_loop_terminal_cost != 0.0 {
        let (stage, terminal) = (report.open_loop_stage_cost, report.open_loop_terminal_cost);
        let _ = write!(out, ": {} stage, {} terminal", readable(stage), readable(terminal));
        if let Some(end) = report.closed_loop_terminal_cost {
            let _ = write!(out, ", which is {} in closed loop", readable(end));
        }
    }
    out
}

fn bounds(report: &ClosedLoopReport) -> String {
    let mut out = match report.constraint_violation_max {
        0.0 => "all kept".to_owned(),
        most => format!("largest violation {}", readable(most)),
    };
    if let Some(v) = &report.constraint_violation_at {
        let side = match v.side {
            BoundSide::Min => "below its min",
            BoundSide::Max => "above its max",
        };
        let time = report.time_unit.text(readable(v.time));
        let _ = write!(out, ": `{}` {side} at sample {} (t = {time})", v.name, v.sample);
    }
    out
}

/// A closed loop as an HTML page with these figures, and links to these files beside it.
pub fn page(
    problem: &ControlProblem,
    report: &ClosedLoopReport,
    figures: &[Figure],
    files: &[(String, String)],
) -> String {
    let outcome = if report.succeeded { "The loop succeeded" } else { "The loop did not succeed" };
    let verdict = format!("{outcome}. Bounds: {}.", bounds(report));
    let lead = format!("<p class=\"verdict\">{}</p>\n", escaped(&verdict)) + &html::figures(figures);
    let (notes, facts): (Vec<_>, Vec<_>) = facts(report).into_iter().partition(|(what, _)| what == "note");
    let mut chapters = vec![Chapter::new("Results", html::facts("Results", facts))];
    if !notes.is_empty() {
        chapters.push(Chapter::new("Notes", html::list(notes.into_iter().map(|(_, said)| said))));
    }
    chapters.push(Chapter::model("Model of the plant", &problem.plant));
    chapters.push(Chapter::files(files));
    Page::new(format!("Closed loop of {}", problem.system.name), lead).chapters(chapters).html()
}

/// What is to be said of samples that took too long; none where there are none.
pub fn late(late: &LateSamples, period_ms: f64) -> Option<String> {
    (late.samples > 0).then(|| {
        format!(
            "{} ({:.1} %) took longer to solve than the sampling period of {} ms, the longest {:.2} ms: on a real \
             plant, their inputs would be late; use fewer steps, method = \"rti\", a time_limit, or a longer dt",
            counted(late.samples, "sample", "samples"),
            100.0 * late.share,
            readable(period_ms),
            late.longest_ms
        )
    })
}

/// What it took to find a plan.
fn effort(steps: usize, programs: usize) -> String {
    let programs = counted(programs, "quadratic program", "quadratic programs");
    if steps == 0 {
        return programs;
    }
    format!("{}, {programs}", counted(steps, "interior-point step", "interior-point steps"))
}

/// Why the method was taken.
fn why(reason: &MethodReason) -> String {
    let percent =
        |change: f64| if change < 1e-4 { "less than 0.01 %".to_owned() } else { format!("{:.2} %", 100.0 * change) };
    match reason {
        MethodReason::Given => "set in the problem file".to_owned(),
        MethodReason::Setting { key } => format!("the problem file sets `{key}`, which selects this method"),
        MethodReason::Friction { names } => {
            format!("the plan can reach dry friction (sign of {})", names.join(", "))
        }
        MethodReason::Targets => "the run ends with the horizon and its targets".to_owned(),
        MethodReason::TerminalCost => "the run ends with the horizon, and the cost is terminal only".to_owned(),
        MethodReason::Free => "free values need a plan".to_owned(),
        MethodReason::Settled { change } => {
            format!("one QP per sample suffices; further QPs change the first plan by {}", percent(*change))
        }
        MethodReason::NotSettled { change: Some(change) } => {
            format!("one QP per sample does not suffice; further QPs change the first plan by {}", percent(*change))
        }
        MethodReason::NotSettled { change: None } => "one QP per sample gives no usable first plan".to_owned(),
        MethodReason::NotConverging => "one QP per sample does not suffice, and more do not converge".to_owned(),
    }
}

/// Why a problem could not be run; where its plant stopped, with the part of the equations that has no value there.
pub fn error(problem: &ControlProblem, error: &ControlError) -> String {
    if let ControlError::Mpc(MpcError::Plant { time, source }) = error
        && let Some(stop) = source.downcast_ref::<PlantStopped>()
        && let Some(why) = Breakdown::find(&problem.plant, &stop.model, &stop.reason, stop.t, &stop.state)
    {
        let why = simulation::breakdown(&problem.plant, &why);
        return format!("the plant stopped at t = {time}: {why} (t = {})", stop.t);
    }
    if let ControlError::Mpc(MpcError::Plant { time, source }) = error
        && let Some(PlantEquations { t, failure }) = source.downcast_ref()
    {
        let why = simulation::breakdown(&problem.plant, &Breakdown::NoRoot(*failure));
        return format!("the plant stopped at t = {time}: {why} (t = {t})");
    }
    error.to_string()
}

/// Names of the columns and rows of a table: time, states, inputs and, where states are estimated, the estimates; then the
/// references and the named constraints.
pub fn table(problem: &ControlProblem, controlled: &Controlled) -> (Vec<String>, Vec<Vec<f64>>) {
    let run = &controlled.run.closed_loop;
    let states = problem.plant.state_names();
    let estimated = problem.estimation.is_some();
    let mut header = vec!["t".to_owned()];
    header.extend(states.iter().cloned());
    header.extend(problem.plant.input_names());
    if estimated {
        header.extend(states.iter().map(|x| format!("estimated {x}")));
    }
    let signals = columns(problem, controlled, &header);
    header.extend(signals.iter().map(|s| s.0.clone()));
    // The last state has no sample of its own: the last applied input and the last estimate stand there.
    let rows = (0..run.t.len())
        .map(|k| {
            let last = k.min(run.u.len() - 1);
            let estimate = run.estimates[last].iter().take(if estimated { states.len() } else { 0 });
            let signals = signals.iter().map(|s| &s.1[k]);
            let t = rounded(run.t[k]);
            let row = std::iter::once(&t).chain(&run.x[k]).chain(&run.u[last]);
            row.chain(estimate).chain(signals).copied().collect()
        })
        .collect();
    (header, rows)
}

/// The predicted trajectory of every sample as a table: sample, time, states, inputs. Empty where predictions were not kept.
pub fn predictions(problem: &ControlProblem, controlled: &Controlled) -> (Vec<String>, Vec<Vec<f64>>) {
    let run = &controlled.run.closed_loop;
    let delay = problem.compensated_delay();
    let mut rows = Vec::new();
    // After the end of a plan nothing is predicted.
    for (sample, plan) in run.predictions.iter().enumerate().filter(|(_, plan)| plan.steps() > 0) {
        let first = run.t[sample] + delay as f64 * problem.ocp.dt;
        rows.extend(planned(plan, first, &problem.ocp).map(|row| [vec![sample as f64], row].concat()));
    }
    let names = [vec!["sample".to_owned(), "t".to_owned()], problem.plant.state_names(), problem.plant.input_names()];
    (names.concat(), rows)
}

/// The plan of a method that makes one, as a table: time, states, inputs.
pub fn plan(problem: &ControlProblem, controlled: &Controlled) -> Option<(Vec<String>, Vec<Vec<f64>>)> {
    let plan = &controlled.run.plan.as_ref()?.trajectory;
    let names = [vec!["t".to_owned()], problem.plant.state_names(), problem.plant.input_names()];
    Some((names.concat(), planned(plan, 0.0, &problem.ocp).collect()))
}

/// Rows of a predicted trajectory; the last state has no input of its own and gets the one before.
fn planned<'a>(plan: &'a PlannedTrajectory, first: f64, ocp: &'a Ocp) -> impl Iterator<Item = Vec<f64>> + 'a {
    (0..=plan.steps()).map(move |k| {
        let last = k.min(plan.steps() - 1);
        [&[rounded(first + ocp.offset(k))], plan.x(k), plan.u(last)].concat()
    })
}

/// A time without the rounding of k·dt in its last digits.
fn rounded(t: f64) -> f64 {
    format!("{t:.12e}").parse().unwrap_or(t)
}

/// States with references, targets, bounds and the modes of friction, inputs, named constraints, and the time of each solution.
///
/// # Errors
/// [`PlotError`] for numbers that no axis holds.
pub fn figure(problem: &ControlProblem, controlled: &Controlled) -> Result<Drawing, PlotError> {
    let run = &controlled.run.closed_loop;
    let (states, inputs) = (problem.plant.state_names(), problem.plant.input_names());
    let quantities = &problem.plant.quantities;
    let estimated = problem.estimation.is_some();
    let mut chart = friction_colors(TimeSeries::new())
        .title(format!("Closed loop, {}", problem.system.name))
        .time_label(problem.plant.quantities.time_title("time"));
    // Between the samples, the plant moves on.
    let motion = &controlled.recording.trajectory;
    let is_discrete = problem.plant.period.is_some();
    let (times, rows) = if is_discrete || motion.dim() != states.len() {
        (run.t.clone(), run.x.clone())
    } else {
        let times = drawn_times(motion);
        let rows = times.iter().map(|&t| motion.sample(t)).collect();
        (times, rows)
    };
    for (k, name) in states.iter().enumerate() {
        let values: Vec<f64> = rows.iter().map(|x| x[k]).collect();
        let label = if estimated {
            "true state"
        } else if is_tracking(problem, name) {
            name
        } else {
            ""
        };
        let mut panel = Panel::new(quantities.title(name));
        let series = Series::new(label, times.clone(), values);
        panel = panel.series(if is_discrete { series.step() } else { series });
        if estimated {
            let values: Vec<f64> = run.estimates.iter().map(|x| x[k]).collect();
            panel = panel.series(Series::new("estimate", run.t[..values.len()].to_vec(), values).dash(Dash::Dashed));
        }
        panel = with_references(panel, problem, &run.t, name);
        for target in problem.ocp.targets.iter().filter(|t| t.state == k) {
            panel = panel.target(target.value);
        }
        let b = problem.ocp.state_bounds[k];
        panel = with_bounds(panel, (b.min, b.max));
        panel = friction_bands(panel, &controlled.recording.trajectory, &controlled.switches, name);
        chart = chart.panel(panel);
    }
    for (k, name) in inputs.iter().enumerate() {
        let mut panel =
            Panel::new(format!("input {}", quantities.title(name))).series(held(&run.t, run.u.iter().map(|u| u[k])));
        panel = with_references(panel, problem, &run.t, name);
        chart = chart.panel(with_bounds(panel, problem.ocp.input_bounds[k]));
    }
    for panel in panels(problem, controlled) {
        chart = chart.panel(panel);
    }
    let milliseconds = run.steps.iter().map(|s| 1e3 * s.timings.total());
    chart = chart.panel(Panel::new("solve time [ms]").series(held(&run.t, milliseconds)));
    chart.draw()
}

/// Values that are held from each time to the next, the last one to the end.
fn held(t: &[f64], values: impl Iterator<Item = f64>) -> Series {
    let mut values: Vec<f64> = values.collect();
    values.extend(values.last().copied());
    Series::new("", t[..values.len().min(t.len())].to_vec(), values).step()
}
