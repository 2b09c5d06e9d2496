//! `bracketry simulate`: trajectory, events, plots.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::report::{Figure, simulation};
use bracketry::sim::{Hold, SampledScenario, Scenario, ScenarioRun, SimulationSettings};
use bracketry::system::{Accepted, System};
use clap::{Args, ValueEnum};

use super::file_kind::{FileKind, Given};
use super::output::{PageArgs, csv, folder, json, line, listed, print, save_figures, write};
use super::progress::spinner;
use super::seed::seed;
use super::{CommonArgs, Outcome};

/// How samples continue.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum HoldArg {
    /// Each value is held until the next sample
    Previous,
    /// Linear interpolation between samples
    Linear,
}

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    (
        "With a scenario; writes trajectory, events, and plots",
        "bracketry simulate models/plate_published.toml --scenario models/plate_experiment_2.toml --out out",
    ),
    ("With recorded inputs", "bracketry simulate slider.toml --inputs run.csv --hold linear --out out"),
    (
        "With sensor noise, for diagnose",
        "bracketry simulate mass.toml --scenario mass_scenario.toml --noise position=0.001 --seed 1 --out out",
    ),
];

/// The page with everything.
const PAGE: &str = "simulation.html";
/// What the table and the figure show.
const TRAJECTORY: &str = "States, inputs, and outputs over time";

/// Arguments of `simulate`.
#[derive(Args)]
pub(crate) struct SimulateArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    model: PathBuf,
    /// Scenario file (TOML): duration, x0, inputs as expressions in t
    #[arg(long, value_name = "FILE", conflicts_with = "inputs", value_hint = clap::ValueHint::FilePath)]
    scenario: Option<PathBuf>,
    /// Table of inputs (CSV): a column t and one per input; der(X,2) for derivatives
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    inputs: Option<PathBuf>,
    /// Interpolation of the samples of --inputs
    #[arg(long, value_enum, default_value = "previous")]
    hold: HoldArg,
    /// Also write measured.csv: inputs, and outputs or states with Gaussian noise of these standard deviations, as a record
    /// for `diagnose`; requires --out
    #[arg(long, value_name = "NAME=STD,…", value_delimiter = ',', value_parser = sensor, requires = "out")]
    noise: Vec<(String, f64)>,
    #[command(flatten)]
    page: PageArgs,
    /// Seed of the noise
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 0, requires = "noise", value_parser = seed)]
    seed: u64,
}

/// A measured name with the standard deviation of its noise.
pub(crate) fn sensor(text: &str) -> Result<(String, f64), String> {
    let parts = text.split_once('=').and_then(|(name, std)| Some((name.trim().to_owned(), std.trim().parse().ok()?)));
    parts.ok_or_else(|| "write an output or a state, =, and the standard deviation of its noise: x=0.001".to_owned())
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
pub(crate) fn run(args: &SimulateArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    args.page.check(output)?;
    let system = System::read_accepting(&args.model, Accepted { discrete: true, algebraic: true })?;
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
        (None, None) => anyhow::bail!(nothing_given(&args.model)),
    };
    let progress = spinner("simulating");
    let run = given
        .scenario
        .run(&system, &SimulationSettings::default())
        .with_context(|| args.model.display().to_string())?;
    progress.finish_and_clear();
    let mut drawn = false;
    if let Some(dir) = &output.out {
        folder(dir)?;
        let mut files = listed(&[("trajectory.csv", TRAJECTORY), ("events.csv", "the mode changes")]);
        if !args.noise.is_empty() {
            let columns = run.measured(&system, &args.noise, args.seed).context("--noise")?;
            write_measured(dir, &run.times, &columns)?;
            files.extend(listed(&[("measured.csv", "what sensors with noise would have measured")]));
        }
        let figures = write_files(dir, &system, &given.scenario, &run)?;
        let saved = save_figures(&figures, dir);
        drawn = !saved.is_empty();
        files.extend(saved);
        let page = dir.join(PAGE);
        write(&page, &simulation::page(&system, &given, &run, &figures, &files))?;
        args.page.open(&page);
    }
    if output.json {
        print(&json(&simulation::json(&system, &given, &run))?)?;
    } else {
        print(&simulation::text(&system, &given, &run))?;
        if let Some(dir) = &output.out {
            let measured = if args.noise.is_empty() { "" } else { ", measured.csv" };
            let figure = if drawn { ", trajectory.svg, trajectory.png" } else { "" };
            line(&format!("written to {}: {PAGE}, trajectory.csv, events.csv{figure}{measured}", dir.display()))?;
        } else {
            line("(--out DIR writes a page with plots, and trajectory and events as tables)")?;
        }
    }
    Ok(if run.simulation.outcome.is_finished() { Outcome::Done } else { Outcome::Negative })
}

/// What to give beside the model, with a scenario that lies beside it if there is one.
fn nothing_given(model: &Path) -> String {
    let scenario = FileKind::Scenario.beside(model);
    let scenario = scenario.map_or_else(|| "FILE.toml".to_owned(), |path| path.display().to_string());
    format!(
        "{}: duration, initial state, and inputs are missing\n   = add --scenario {scenario} (duration, x0, inputs as \
         expressions in t), or --inputs FILE.csv (samples of the inputs); `bracketry new NAME` writes a scenario",
        model.display()
    )
}

/// What sensors would have given.
fn write_measured(dir: &Path, times: &[f64], columns: &[(String, Vec<f64>)]) -> anyhow::Result<()> {
    let header: Vec<String> = ["t".to_owned()].into_iter().chain(columns.iter().map(|c| c.0.clone())).collect();
    let row = |k: usize| [times[k]].into_iter().chain(columns.iter().map(|c| c.1[k])).collect::<Vec<f64>>();
    let rows: Vec<Vec<f64>> = (0..times.len()).map(row).collect();
    csv(&dir.join("measured.csv"), &header, rows.iter().map(Vec::as_slice))
}

/// Writes the tables; gives the figures.
fn write_files(dir: &Path, system: &System, scenario: &Scenario, run: &ScenarioRun) -> anyhow::Result<Vec<Figure>> {
    let (header, rows) = simulation::table(system, scenario, run);
    csv(&dir.join("trajectory.csv"), &header, rows.iter().map(Vec::as_slice))?;
    let events_path = dir.join("events.csv");
    let mut events =
        csv::Writer::from_path(&events_path).with_context(|| format!("cannot write {}", events_path.display()))?;
    events.write_record(["t", "switch", "from", "to"])?;
    for e in simulation::events(run) {
        events.write_record([&e.t.to_string(), &e.switch, e.from, e.to])?;
    }
    events.flush()?;
    Ok(vec![Figure::new("trajectory", TRAJECTORY, simulation::figure(system, scenario, run))])
}
