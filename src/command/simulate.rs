//! `bracketry simulate`: trajectory, events, plots.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::sim::{Hold, Settings};
use bracketry::system::System;
use bracketry::{Run, SampledScenario, Scenario, SimulationReport};
use clap::{Args, ValueEnum};

use super::file_kind::{FileKind, Given};
use super::output::{csv, figure, folder, json, line, print, spinner};
use super::{Outcome, OutputArgs};

/// How samples continue.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum HoldArg {
    /// Each value lasts until the next sample
    Previous,
    /// Straight lines between samples
    Linear,
}

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 2] = [
    (
        "By a scenario, with trajectory, events and plots",
        "bracketry simulate models/plate_published.toml --scenario models/plate_experiment_2.toml --out out",
    ),
    ("By recorded inputs", "bracketry simulate slider.toml --inputs run.csv --hold linear --out out"),
];

/// Arguments of `simulate`.
#[derive(Args)]
pub(crate) struct SimulateArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    model: PathBuf,
    /// Scenario file (TOML): duration, x0, inputs as expressions in t
    #[arg(long, value_name = "FILE", conflicts_with = "inputs", required_unless_present = "inputs",
        value_hint = clap::ValueHint::FilePath)]
    scenario: Option<PathBuf>,
    /// Table of inputs (CSV): a column t and one per input; der(X,2) for derivatives
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    inputs: Option<PathBuf>,
    /// How the samples of --inputs continue
    #[arg(long, value_enum, default_value = "previous")]
    hold: HoldArg,
}

impl SimulateArgs {
    pub(crate) fn files(&self) -> Vec<Given> {
        let mut files = vec![Given::new(&self.model, FileKind::Model)];
        files.extend(self.scenario.iter().map(|path| Given::new(path, FileKind::Scenario)));
        files.extend(self.inputs.iter().map(|path| Given::new(path, FileKind::Table)));
        files
    }
}

/// Runs the simulation and writes what it gave.
pub(crate) fn run(args: &SimulateArgs, output: &OutputArgs) -> anyhow::Result<Outcome> {
    let system = System::read(&args.model)?;
    let given = match (&args.scenario, &args.inputs) {
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
    let run = given.scenario.run(&system, &Settings::default())?;
    progress.finish_and_clear();
    let report = SimulationReport::new(&system, &given, &run);
    if let Some(dir) = &output.out {
        folder(dir)?;
        write_files(dir, &system, &given.scenario, &run)?;
    }
    if output.json {
        print(&json(&report)?)?;
    } else {
        print(&report.to_string())?;
        if let Some(dir) = &output.out {
            line(&format!("written to {}: trajectory.csv, events.csv, trajectory.svg, trajectory.png", dir.display()))?;
        } else {
            line("(--out DIR writes trajectory, events and plots)")?;
        }
    }
    Ok(if report.finished { Outcome::Done } else { Outcome::Negative })
}

fn write_files(dir: &Path, system: &System, scenario: &Scenario, run: &Run) -> anyhow::Result<()> {
    let (header, rows) = run.table(system, scenario);
    csv(&dir.join("trajectory.csv"), &header, rows.iter().map(Vec::as_slice))?;
    let events_path = dir.join("events.csv");
    let mut events =
        csv::Writer::from_path(&events_path).with_context(|| format!("cannot write {}", events_path.display()))?;
    events.write_record(["t", "switch", "from", "to"])?;
    for e in run.mode_changes() {
        events.write_record([&e.t.to_string(), &e.switch, e.from, e.to])?;
    }
    events.flush()?;
    figure(run.figure(system, scenario), &dir.join("trajectory"));
    Ok(())
}
