//! `bracketry simulate`: trajectory, events, plots.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::plot::{Panel, Series, TimeSeries};
use bracketry::sim::{Hold, Mode, Outcome as SimOutcome, Settings};
use bracketry::symbolic::Node;
use bracketry::system::System;
use bracketry::{Run, SampledScenario, Scenario};
use clap::{Args, ValueEnum};
use serde_json::json;

use super::bands::{friction_bands, friction_colors};
use super::output::{csv, figure, folder, json, line, print, spinner};
use super::{Outcome, OutputArgs};

/// A column that stays below this is drawn as zero.
const ROUNDING: f64 = 1e-13;

/// How samples continue.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum HoldArg {
    /// Each value lasts until the next sample
    Previous,
    /// Straight lines between samples
    Linear,
}

/// Arguments of `simulate`.
#[derive(Args)]
pub(crate) struct SimulateArgs {
    /// Model file
    model: PathBuf,
    /// Scenario file (TOML): duration, x0, inputs as expressions in t
    #[arg(long, conflicts_with = "inputs", required_unless_present = "inputs")]
    scenario: Option<PathBuf>,
    /// Table of inputs (CSV): a column t and one per input; der(X,2) for derivatives
    #[arg(long)]
    inputs: Option<PathBuf>,
    /// How the samples of --inputs continue
    #[arg(long, value_enum, default_value = "previous")]
    hold: HoldArg,
}

/// Runs the simulation and writes what it gave.
pub(crate) fn run(args: &SimulateArgs, output: &OutputArgs) -> anyhow::Result<Outcome> {
    let system = System::read(&args.model)?;
    let SampledScenario { scenario, ignored, held_at_zero } = match (&args.scenario, &args.inputs) {
        (Some(path), _) => {
            let scenario = Scenario::read(path, &system)?;
            let held_at_zero = scenario.inputs_at_zero(&system);
            SampledScenario { scenario, ignored: Vec::new(), held_at_zero }
        }
        (None, Some(path)) => {
            let hold = match args.hold {
                HoldArg::Previous => Hold::Previous,
                HoldArg::Linear => Hold::Linear,
            };
            Scenario::from_csv(path, &system, hold)?
        }
        (None, None) => anyhow::bail!("give --scenario FILE.toml or --inputs FILE.csv"),
    };
    let progress = spinner("simulating");
    let run = scenario.run(&system, &Settings::default())?;
    progress.finish_and_clear();
    let states = system.state_names();
    let last = run.trajectory.final_state();
    let stopped = match &run.outcome {
        SimOutcome::Finished => None,
        SimOutcome::Stopped { reason, t, .. } => {
            let at = number(*t, |t| format!("{t:.6}"));
            let state =
                run.not_finite.as_ref().map_or(String::new(), |n| format!("; the rate of `{n}` is not finite there"));
            Some(format!("stopped at t = {at} s: {reason}{state}"))
        }
    };
    let impulses: Vec<String> = run.impulses_left_out.iter().map(|(n, order)| format!("der({n},{order})")).collect();
    if let Some(dir) = &output.out {
        folder(dir)?;
        write_files(dir, &system, &scenario, &run)?;
    }
    if output.json {
        let x_final: serde_json::Map<String, serde_json::Value> =
            states.iter().cloned().zip(last.iter().map(|v| json!(v))).collect();
        let transitions: Vec<_> = run
            .trajectory
            .transitions()
            .iter()
            .map(|e| json!({"t": e.t, "switch": run.switches[e.switch], "from": mode_name(e.from), "to": mode_name(e.to)}))
            .collect();
        print(&json(&json!({"model": system.name, "t_final": run.trajectory.end(), "x_final": x_final,
                "finished": stopped.is_none(), "stopped": stopped, "events": transitions,
                "steps": run.statistics.steps, "ignored_columns": ignored,
                "inputs_at_zero": held_at_zero, "impulses_left_out": impulses}))?)?;
    } else {
        line(&format!(
            "{}: {} s simulated in {}, {}",
            system.name,
            number(run.trajectory.end() - run.trajectory.start(), |t| t.to_string()),
            count(run.statistics.steps, "step", "steps"),
            count(run.trajectory.transitions().len(), "change of mode", "changes of mode")
        ))?;
        for name in &held_at_zero {
            line(&format!("  nothing drives the input `{name}`: it is zero"))?;
        }
        for ((input, _), derivative) in run.impulses_left_out.iter().zip(&impulses) {
            line(&format!("  warning: `{input}` jumps or has kinks: impulses of {derivative} are left out"))?;
        }
        for name in &ignored {
            line(&format!("  column `{name}` is no input that the model uses and was ignored"))?;
        }
        for (n, v) in states.iter().zip(last) {
            line(&format!("  {n:>10} = {}", number(*v, |v| format!("{v:.9}"))))?;
        }
        if let Some(s) = &stopped {
            line(s)?;
        }
        if let Some(dir) = &output.out {
            line(&format!("written to {}: trajectory.csv, events.csv, trajectory.svg, trajectory.png", dir.display()))?;
        } else {
            line("(--out DIR writes trajectory, events and plots)")?;
        }
    }
    Ok(if stopped.is_some() { Outcome::Negative } else { Outcome::Done })
}

/// `write`, but scientific notation for what has too many digits.
fn number(v: f64, write: impl Fn(f64) -> String) -> String {
    if v.abs() < 1e9 { write(v) } else { format!("{v:e}") }
}

/// A number of things, with their name in the singular or the plural.
fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Plot panels of outputs are drawn up to this many.
const MAX_OUTPUT_PANELS: usize = 6;

/// The outputs that have no column of their own yet, by index, with the names of their columns.
fn output_columns(system: &System) -> Vec<(usize, String)> {
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

/// A mode in words.
pub(crate) fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Positive => "+1",
        Mode::Negative => "-1",
        Mode::Sliding => "slide",
        Mode::Sticking => "stick",
    }
}

fn write_files(dir: &Path, system: &System, scenario: &Scenario, run: &Run) -> anyhow::Result<()> {
    let mut header = vec!["t".to_owned()];
    header.extend(system.state_names());
    let mut inputs: Vec<(usize, String)> = system.input_names().into_iter().enumerate().collect();
    // Nothing is known of an input of which only derivatives are given.
    inputs.retain(|(_, name)| !scenario.inputs.only_derivatives(name));
    let outputs = output_columns(system);
    header.extend(inputs.iter().chain(&outputs).map(|(_, name)| name.clone()));
    let rows: Vec<Vec<f64>> = run
        .times
        .iter()
        .zip(run.states.iter().zip(run.inputs.iter().zip(&run.outputs)))
        .map(|(t, (x, (u, y)))| {
            let driven = inputs.iter().map(|(k, _)| u[*k]);
            let measured = outputs.iter().map(|(k, _)| y[*k]);
            std::iter::once(*t).chain(x.iter().copied()).chain(driven).chain(measured).collect()
        })
        .collect();
    csv(&dir.join("trajectory.csv"), &header, rows.iter().map(Vec::as_slice))?;
    let events_path = dir.join("events.csv");
    let mut events =
        csv::Writer::from_path(&events_path).with_context(|| format!("cannot write {}", events_path.display()))?;
    events.write_record(["t", "switch", "from", "to"])?;
    for e in run.trajectory.transitions() {
        events.write_record([&e.t.to_string(), &run.switches[e.switch], mode_name(e.from), mode_name(e.to)])?;
    }
    events.flush()?;

    let mut chart = friction_colors(TimeSeries::new()).title(system.name.clone());
    // Rounding on a sticking surface is not worth an axis of its own.
    let column = |k: usize, rows: &[Vec<f64>]| {
        let values: Vec<f64> = rows.iter().map(|r| r[k]).collect();
        if values.iter().all(|v| v.abs() < ROUNDING) { vec![0.0; values.len()] } else { values }
    };
    for (k, name) in system.state_names().into_iter().enumerate() {
        let mut panel = Panel::new(name.clone()).series(Series::new("", run.times.clone(), column(k, &run.states)));
        panel = friction_bands(panel, &run.trajectory, &run.switches, &name);
        chart = chart.panel(panel);
    }
    for (k, name) in &inputs {
        let series = Series::new("", run.times.clone(), column(*k, &run.inputs));
        chart = chart.panel(Panel::new(format!("input {name}")).series(series));
    }
    if outputs.len() <= MAX_OUTPUT_PANELS {
        for (k, name) in &outputs {
            let series = Series::new("", run.times.clone(), column(*k, &run.outputs));
            chart = chart.panel(Panel::new(name.clone()).series(series));
        }
    }
    figure(chart.draw(), &dir.join("trajectory"));
    Ok(())
}
