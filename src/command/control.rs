//! `bracketry control`: the closed loop of a problem file.

use std::path::Path;

use bracketry::mpc::{ControlProblem, MpcError};
use bracketry::plot::{Dash, Panel, Series, TimeSeries};
use bracketry::{ControlError, Controlled, control_watched};

use super::bands::{friction_bands, friction_colors};
use super::output::{csv, figure, folder, json, line, print, spinner, write};
use super::{Outcome, OutputArgs};

/// Runs the loop and writes what it gave.
pub(crate) fn run(path: &Path, seed: Option<u64>, output: &OutputArgs) -> anyhow::Result<Outcome> {
    let progress = spinner("reading and building the problem");
    let mut problem = ControlProblem::read(path)?;
    if let Some(seed) = seed {
        problem.conditions.seed = seed;
    }
    progress.set_message("first plan");
    let total = problem.samples;
    let outcome = control_watched(&problem, |k| progress.set_message(format!("closed loop, sample {k} of {total}")));
    progress.finish_and_clear();
    let controlled = match outcome {
        // The loop ran until its plant ended: an answer, though a negative one.
        Err(ControlError::Mpc(stop @ MpcError::Plant { .. })) => {
            eprintln!("{stop}");
            return Ok(Outcome::Negative);
        }
        other => other?,
    };
    let report = &controlled.run.report;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("control.json"), &json(report)?)?;
        write_files(dir, &problem, &controlled)?;
    }
    if output.json {
        print(&json(report)?)?;
    } else {
        print(&report.to_string())?;
        match &output.out {
            Some(dir) => line(&format!(
                "written to {}: control.json, closed_loop.csv, closed_loop.svg, closed_loop.png",
                dir.display()
            ))?,
            None => line("(--out DIR writes trajectory and plots)")?,
        }
    }
    Ok(if report.succeeded { Outcome::Done } else { Outcome::Negative })
}

/// A time without the rounding of k·dt in its last digits.
fn rounded(t: f64) -> f64 {
    format!("{t:.12e}").parse().unwrap_or(t)
}

fn write_files(dir: &Path, problem: &ControlProblem, controlled: &Controlled) -> anyhow::Result<()> {
    let run = &controlled.run.closed_loop;
    let (states, inputs) = (problem.plant.state_names(), problem.plant.input_names());
    let estimated = problem.estimation.is_some();
    let mut header = vec!["t".to_owned()];
    header.extend(states.iter().cloned());
    header.extend(inputs.iter().cloned());
    if estimated {
        header.extend(states.iter().map(|x| format!("estimated {x}")));
    }
    // The last state has no sample of its own: the last applied input and the last estimate stand there.
    let rows: Vec<Vec<f64>> = (0..run.t.len())
        .map(|k| {
            let last = k.min(run.u.len() - 1);
            let estimate = run.estimates[last].iter().take(if estimated { states.len() } else { 0 });
            std::iter::once(&rounded(run.t[k])).chain(&run.x[k]).chain(&run.u[last]).chain(estimate).copied().collect()
        })
        .collect();
    csv(&dir.join("closed_loop.csv"), &header, rows.iter().map(Vec::as_slice))?;

    let mut chart = friction_colors(TimeSeries::new()).title(format!("Closed loop, {}", problem.system.name));
    for (k, name) in states.iter().enumerate() {
        let values: Vec<f64> = run.x.iter().map(|x| x[k]).collect();
        let label = if estimated { "true state" } else { "" };
        let mut panel = Panel::new(name.clone()).series(Series::new(label, run.t.clone(), values));
        if estimated {
            let values: Vec<f64> = run.estimates.iter().map(|x| x[k]).collect();
            panel = panel.series(Series::new("estimate", run.t[..values.len()].to_vec(), values).dash(Dash::Dashed));
        }
        for target in problem.ocp.targets.iter().filter(|t| t.state == k) {
            panel = panel.target(target.value);
        }
        let b = problem.ocp.state_bounds[k];
        for bound in [b.min, b.max].into_iter().filter(|b| b.is_finite()) {
            panel = panel.bound(bound);
        }
        panel = friction_bands(panel, &controlled.recording.trajectory, &controlled.switches, name);
        chart = chart.panel(panel);
    }
    for (k, name) in inputs.iter().enumerate() {
        let mut panel = Panel::new(format!("input {name}")).series(held(&run.t, run.u.iter().map(|u| u[k])));
        let (min, max) = problem.ocp.input_bounds[k];
        for bound in [min, max].into_iter().filter(|b| b.is_finite()) {
            panel = panel.bound(bound);
        }
        chart = chart.panel(panel);
    }
    let milliseconds = run.steps.iter().map(|s| 1e3 * s.timings.total());
    chart = chart.panel(Panel::new("solve time [ms]").series(held(&run.t, milliseconds)));
    figure(chart.draw(), &dir.join("closed_loop"));
    Ok(())
}

/// Values that are held from each time to the next, the last one to the end.
fn held(t: &[f64], values: impl Iterator<Item = f64>) -> Series {
    let mut values: Vec<f64> = values.collect();
    values.extend(values.last().copied());
    Series::new("", t[..values.len().min(t.len())].to_vec(), values).step()
}
