//! Runs random trials of the plate's controllers on the area-contact plant and draws the figures of `docs/records/plate_control.md`:
//! `cargo run --release -p bracketry-trials --example plate_control --features measure -- --trials 200 --case robust`
#![allow(clippy::print_stdout)]

mod figures;

use anyhow::{Context, bail};
use bracketry_plate::PlateError;
use bracketry_plate::control::{PlateController, PoseController, PoseSettings};
use bracketry_trials::{
    AveragedController, CycleGrid, CycleMap, Quantiles, Trial, TrialError, TrialFile, TrialReport, TrialSetup,
    TrialSummary, TwoStepController, median_time_ratio, run_trial, run_trials,
};
use clap::{Parser, ValueEnum};
use figures::Figures;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Random trials of controllers of the plate.
#[derive(Parser)]
struct Arguments {
    /// Number of trials.
    #[arg(long, default_value_t = 200)]
    trials: usize,
    /// Case of the file of trials.
    #[arg(long, default_value = "robust")]
    case: String,
    /// Object of the file of trials.
    #[arg(long, default_value = "ellipse")]
    object: String,
    /// Controllers, all unless given.
    #[arg(long, value_enum)]
    controller: Vec<Kind>,
    /// Seed of the series.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// File of trials.
    #[arg(long)]
    file: Option<PathBuf>,
    /// Folder for figures and reports.
    #[arg(long, default_value = "out/plate_control")]
    out: PathBuf,
}

/// Makes the controller of a trial.
type Make<'a> = dyn Fn(&Trial) -> Result<Box<dyn PlateController>, TrialError> + Sync + 'a;

/// The controllers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    Mpc,
    Averaged,
    TwoStep,
}

impl Kind {
    fn name(self) -> &'static str {
        match self {
            Self::Mpc => "predictive",
            Self::Averaged => "cycle-averaged",
            Self::TwoStep => "two steps",
        }
    }

    fn key(self) -> &'static str {
        match self {
            Self::Mpc => "mpc",
            Self::Averaged => "averaged",
            Self::TwoStep => "two_step",
        }
    }

    /// What makes this controller for a trial. The map of the averaged one, which is the same for all, is computed first.
    fn maker(self, setup: &TrialSetup, mu: f64) -> anyhow::Result<Box<Make<'_>>> {
        Ok(match self {
            Self::Mpc => Box::new(|trial| {
                let settings = PoseSettings {
                    delay: trial.delay,
                    limits: setup.limits,
                    mu: trial.model_mu,
                    mu_deviation: trial.mu_deviation,
                    noise: [trial.position_noise, trial.angle_noise],
                    tolerance: [setup.tolerance.position, setup.tolerance.angle],
                    ..PoseSettings::default()
                };
                Ok(Box::new(PoseController::new(&setup.object, trial.target, &settings)?))
            }),
            Self::Averaged => {
                let grid = CycleGrid::default();
                let bar = progress("map of cycles", CycleMap::count(&setup.object, &grid));
                let begin = Instant::now();
                let map = Arc::new(CycleMap::new(&setup.object, mu, &grid, |done| tell(&bar, done))?);
                bar.finish_and_clear();
                println!("map of cycles: {:.1} s", begin.elapsed().as_secs_f64());
                Box::new(move |trial| Ok(Box::new(AveragedController::new(Arc::clone(&map), trial, setup))))
            }
            Self::TwoStep => Box::new(|trial| Ok(Box::new(TwoStepController::new(trial, setup)?))),
        })
    }
}

/// What is written to the report.
#[derive(Serialize)]
struct Report<'a> {
    case: &'a str,
    object: &'a str,
    controller: &'a str,
    seed: u64,
    summary: TrialSummary,
    trials: &'a [TrialReport],
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let path = arguments
        .file
        .clone()
        .unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models/plate_trials.toml"));
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let file = TrialFile::parse(&text).with_context(|| path.display().to_string())?;
    let names = |all: Vec<&String>| all.into_iter().cloned().collect::<Vec<_>>().join(", ");
    let Some(scenario) = file.cases.get(&arguments.case) else {
        bail!("there is no case `{}`; there are {}", arguments.case, names(file.cases.keys().collect()));
    };
    let Some(object) = file.objects.get(&arguments.object) else {
        bail!("there is no object `{}`; there are {}", arguments.object, names(file.objects.keys().collect()));
    };
    let setup = TrialSetup::new(object, scenario);
    let trials = scenario.trials(arguments.seed, arguments.trials);
    let kinds = if arguments.controller.is_empty() { Kind::value_variants() } else { &arguments.controller };
    std::fs::create_dir_all(&arguments.out).with_context(|| format!("cannot make {}", arguments.out.display()))?;

    println!("{}: {} trials of {}, seed {}", arguments.case, arguments.trials, arguments.object, arguments.seed);
    println!(
        "| controller | reached (95 %) | time: median, 5 %…95 % [s] | bounds kept | planning: median, max [s] | sample: median, 99 % [ms] | failures |"
    );
    println!("|---|---|---|---|---|---|---|");
    let mut all = Vec::new();
    for &kind in kinds {
        let make = kind.maker(&setup, scenario.mu)?;
        let bar = progress(kind.name(), trials.len());
        let reports = run_trials(&trials, &setup, |trial| make(trial).map(Boxed), |done| tell(&bar, done))?;
        bar.finish_and_clear();
        let summary = TrialSummary::of(&reports);
        print_row(kind.name(), &summary);
        let report = Report {
            case: &arguments.case,
            object: &arguments.object,
            controller: kind.key(),
            seed: arguments.seed,
            summary,
            trials: &reports,
        };
        let name = format!("{}_{}_{}.json", arguments.case, arguments.object, kind.key());
        let path = arguments.out.join(name);
        std::fs::write(&path, serde_json::to_string_pretty(&report)?)
            .with_context(|| format!("cannot write {}", path.display()))?;
        all.push((kind, reports, make));
    }
    let figures = Figures {
        folder: arguments.out.clone(),
        stem: format!("control_{}_{}", arguments.case, arguments.object),
        what: format!("{}, {}", arguments.case, arguments.object),
    };
    let named: Vec<(&str, &[TrialReport])> = all.iter().map(|(kind, reports, _)| (kind.name(), &reports[..])).collect();
    figures.times(&named)?;
    figures.errors(&named, setup.tolerance)?;
    for (kind, reports, make) in &all {
        figures.success(kind.name(), kind.key(), reports)?;
        if let Some(report) = typical(reports) {
            let mut controller = make(&report.trial).map(Boxed)?;
            let run = run_trial(&report.trial, &setup, &mut controller)?;
            figures.trial(kind.name(), kind.key(), report, &run, &setup)?;
        }
    }
    for (kind, reports, _) in &all {
        let baseline = all.iter().find(|(other, ..)| *other == Kind::TwoStep);
        if let Some((_, baseline, _)) = baseline.filter(|(other, ..)| other != kind) {
            let ratio = median_time_ratio(reports, baseline);
            println!("median ratio of the times, {} to two steps: {}", kind.name(), number(ratio, 1.0, 3));
        }
    }
    Ok(())
}

/// The trial whose time to target is the median of those that arrived.
fn typical(reports: &[TrialReport]) -> Option<&TrialReport> {
    let mut reached: Vec<&TrialReport> = reports.iter().filter(|r| r.outcome.time().is_some()).collect();
    reached.sort_by(|a, b| a.time().total_cmp(&b.time()));
    reached.get(reached.len() / 2).copied()
}

/// A controller of any kind.
struct Boxed(Box<dyn PlateController>);

impl PlateController for Boxed {
    fn period(&self) -> f64 {
        self.0.period()
    }

    fn command(
        &mut self,
        measurement: &bracketry_plate::control::Measurement,
    ) -> Result<bracketry_plate::control::Command, PlateError> {
        self.0.command(measurement)
    }

    fn finished(&self) -> bool {
        self.0.finished()
    }
}

fn progress(what: &str, count: usize) -> ProgressBar {
    let bar = ProgressBar::new(count as u64).with_message(what.to_owned());
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
        bar.set_style(style);
    }
    bar
}

fn tell(bar: &ProgressBar, done: usize) -> ControlFlow<()> {
    bar.set_position(done as u64);
    ControlFlow::Continue(())
}

/// A number in other units, or a dash where it is infinite.
fn number(value: Option<f64>, factor: f64, decimals: usize) -> String {
    value.map_or("–".into(), |value| format!("{:.decimals$}", factor * value))
}

fn print_row(name: &str, summary: &TrialSummary) {
    let TrialSummary { reached, bounds_kept, time, planning, sample_p50, sample_p99, .. } = summary;
    let share = |s: &bracketry_trials::Share| format!("{}/{}", s.count, s.of);
    let of = |q: &Quantiles| number(q.p50, 1.0, 2);
    let failures: Vec<String> = summary
        .outcomes
        .iter()
        .filter(|(label, _)| *label != "reached")
        .map(|(label, count)| format!("{count} {label}"))
        .collect();
    println!(
        "| {name} | {}, {:.1} % ({:.1}…{:.1}) | {}, {}…{} | {} | {}, {} | {}, {} | {} |",
        share(reached),
        100.0 * reached.value(),
        100.0 * reached.low,
        100.0 * reached.high,
        of(time),
        number(time.p5, 1.0, 2),
        number(time.p95, 1.0, 2),
        share(bounds_kept),
        number(planning.p50, 1.0, 3),
        number(planning.max, 1.0, 3),
        number(sample_p50.p50, 1e3, 3),
        number(sample_p99.p50, 1e3, 3),
        if failures.is_empty() { "none".into() } else { failures.join(", ") },
    );
}
