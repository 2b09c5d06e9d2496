//! Effects hidden in logs of an object on the vibrating plate, and what a diagnosis makes of them.
//!
//! Every run draws an effect and its direction, records experiment 1, experiment 3 and a multisine on the area contact at
//! 200 Hz with noise of 0.5 mm and 0.3°, and diagnoses the model of a disk with these three logs together; it sees nothing
//! but them.
//!
//! ```text
//! cargo run --release --example diagnose_plate                                   # 16 random effects
//! cargo run --release --example diagnose_plate -- --runs 40 --seed 7
//! cargo run --release --example diagnose_plate -- --effect actuator_lag --runs 5
//! cargo run --release --example diagnose_plate -- --out logs                      # the logs alone, with their truth apart
//! cargo run --release --example diagnose_plate -- --logs ../shared/data/plate --seconds 6   # logs of an independent engine
//! ```
#![allow(clippy::print_stdout)]

use anyhow::Context;
use bracketry::report::diagnosis_text;
use bracketry_diagnose::{
    Cause, DiagnosisSettings, Record, RecordSettings, Report, diagnose, read_record, reference_candidates,
};
use bracketry_plate::experiment::Experiment;
use bracketry_plate::recording::{PlateMismatch, RecordingError, RecordingSettings, multisine, synthetic_log};
use bracketry_plate::{Object, PlateLog, Shape};
use bracketry_sim::Hold;
use bracketry_system::System;
use bracketry_trials::Score;
use clap::Parser;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[derive(Parser)]
// Each switch is one of the command line.
#[allow(clippy::struct_excessive_bools)]
struct Options {
    /// Runs.
    #[arg(long, default_value_t = 16)]
    runs: u64,
    /// Seed of effects, multisines and noise.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One kind of effect in all runs, such as actuator_lag, none; drawn if absent.
    #[arg(long)]
    effect: Option<String>,
    /// The model to diagnose.
    #[arg(long, default_value = "models/plate_disk.toml")]
    model: PathBuf,
    /// The object: disk or ellipse, of the reference sizes.
    #[arg(long, default_value = "disk")]
    shape: String,
    /// Length of experiment 1 and the multisine in s; experiment 3 takes five at most.
    #[arg(long, default_value_t = 8.0)]
    seconds: f64,
    /// The multisine alone, in place of the three logs.
    #[arg(long)]
    multisine: bool,
    /// Length of the windows in s; chosen from the data if absent.
    #[arg(long)]
    window: Option<f64>,
    /// Logs with columns of the plate's accelerations.
    #[arg(long)]
    derivatives: bool,
    /// Most causes that are named.
    #[arg(long)]
    max_causes: Option<usize>,
    /// Another model of the plate: terms of its equations that the diagnosed one lacks become candidates.
    #[arg(long)]
    reference: Option<PathBuf>,
    /// A further multisine of every plant, that no fit sees, to measure the gain on.
    #[arg(long)]
    held_out: bool,
    /// Diagnoses the CSV files of this folder, one by one, in place of logs of the area contact: columns `t`, `plate_X`,
    /// `plate_theta` of the plate and `x_plate`, `y_plate`, `phi_plate` of the object.
    #[arg(long)]
    logs: Option<PathBuf>,
    /// Prints every report.
    #[arg(long)]
    full: bool,
    /// Writes logs and truth into this folder and diagnoses nothing.
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Columns of the independent engine and their names in the model.
const RENAMED: [(&str, &str); 5] =
    [("plate_X", "X"), ("plate_theta", "theta"), ("x_plate", "x"), ("y_plate", "y"), ("phi_plate", "phi")];

/// What a diagnosis makes of the logs in a folder, one by one.
fn independent(folder: &Path, system: &System, settings: &DiagnosisSettings, full: bool) -> anyhow::Result<()> {
    let rename = RENAMED.map(|(column, name)| (column.to_owned(), name.to_owned())).to_vec();
    let reading = RecordSettings { hold: Some(Hold::Linear), rename, ..Default::default() };
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<anyhow::Result<_>>()?;
    paths.retain(|path| path.extension().is_some_and(|e| e == "csv"));
    paths.sort();
    println!("| log | found | verdict | residual over noise, refitted | extended | s |\n|---|---|---|---|---|---|");
    for path in paths {
        let record = read_record(&path, system, &reading)?;
        let report = diagnose(system, &[record], &[], settings, &mut |_| ())?;
        let number = |value: Option<f64>| value.map_or_else(String::new, |v| format!("{v:.3}"));
        println!(
            "| {} | {} | {:?} | {} | {} | {:.1} |",
            path.file_stem().unwrap_or_default().to_string_lossy(),
            named(&report),
            report.verdict,
            number(report.excess.as_ref().map(|e| e.refitted)),
            number(report.excess.as_ref().and_then(|e| e.extended)),
            report.seconds
        );
        if full {
            println!("\n{}\n", diagnosis_text(&report, None));
        }
    }
    Ok(())
}

/// The logs of one plant.
fn logs(
    effect: &PlateMismatch,
    settings: &RecordingSettings,
    seed: u64,
    options: &Options,
) -> Result<Vec<PlateLog>, RecordingError> {
    let start = |y: f64| [0.3, y, 0.0, 0.0, 0.0, 0.0];
    let seconds = options.seconds;
    let shaken = multisine(start(0.0), seconds, settings, seed)?;
    let mut experiments = vec![(shaken, 0.0, seconds)];
    if !options.multisine {
        experiments.push((Experiment::orientation(), 0.0, seconds));
        experiments.push((Experiment::translation_y(), -0.03, seconds.min(5.0)));
    }
    experiments
        .into_iter()
        .enumerate()
        .map(|(i, (experiment, y, duration))| {
            Ok(synthetic_log(&experiment, start(y), duration, effect, settings, 3 * seed + i as u64)?.log)
        })
        .collect()
}

/// A multisine of another seed.
fn held_out(
    effect: &PlateMismatch,
    settings: &RecordingSettings,
    seed: u64,
    options: &Options,
) -> Result<PlateLog, RecordingError> {
    let start = [0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
    let other = !seed;
    let shaken = multisine(start, options.seconds, settings, other)?;
    Ok(synthetic_log(&shaken, start, options.seconds, effect, settings, other)?.log)
}

fn cause(effect: &PlateMismatch) -> Option<Cause> {
    match effect {
        PlateMismatch::None => None,
        PlateMismatch::TiltAboutX(_) | PlateMismatch::TiltAboutY(_) => Some(Cause::Tilt),
        PlateMismatch::Friction(_) => Some(Cause::ParameterError),
        PlateMismatch::ActuatorLag(_) => Some(Cause::ActuatorLag),
        PlateMismatch::CenterOfMass(_) => Some(Cause::ComOffset),
        PlateMismatch::SensorDelay(_) => Some(Cause::SensorDelay),
        PlateMismatch::AnisotropicFriction(_) => Some(Cause::AnisotropicFriction),
        PlateMismatch::PressureRadius(_) => Some(Cause::PressureRadius),
    }
}

/// The causes with their equations, values and what they may be confused with.
fn named(report: &Report) -> String {
    let each = report.causes.iter().map(|c| {
        let values: Vec<String> =
            c.parameters.iter().map(|(n, v)| format!("{n} = {:.3e} ± {:.0e}", v.value, v.std)).collect();
        let rivals: Vec<String> = c.confusable_with.iter().map(ToString::to_string).collect();
        let or = if rivals.is_empty() { String::new() } else { format!(" (or {})", rivals.join(", ")) };
        format!("{} in {}: {}{or}", c.name, c.equation, values.join(", "))
    });
    let all: Vec<String> = each.collect();
    if all.is_empty() { format!("{:?}", report.verdict) } else { all.join("; ") }
}

fn main() -> anyhow::Result<()> {
    let options = Options::parse();
    let text = std::fs::read_to_string(&options.model).with_context(|| options.model.display().to_string())?;
    let system = System::parse(&options.model.display().to_string(), &text)?;
    let mut settings = DiagnosisSettings::default();
    settings.study.window = options.window;
    if let Some(most) = options.max_causes {
        settings.max_causes = most;
    }
    if let Some(path) = &options.reference {
        settings.candidates = reference_candidates(&system, &System::read(path)?)?;
    }
    if let Some(folder) = &options.logs {
        return independent(folder, &system, &settings, options.full);
    }
    let object = match options.shape.as_str() {
        "disk" => Object::REFERENCE,
        "ellipse" => Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE },
        other => anyhow::bail!("--shape {other}: choose disk or ellipse"),
    };
    let log_settings = RecordingSettings { object, derivatives: options.derivatives, ..RecordingSettings::default() };
    let mut scores: BTreeMap<&str, BTreeMap<&str, u32>> = BTreeMap::new();
    if options.out.is_none() {
        println!("| run | hidden | found | score | s |\n|---|---|---|---|---|");
    }
    for run in 0..options.runs {
        let seed = options.seed.wrapping_mul(1_000_003).wrapping_add(run);
        let effect = match &options.effect {
            None => PlateMismatch::draw(seed),
            Some(kind) => PlateMismatch::draw_kind(kind, seed)
                .with_context(|| format!("--effect {kind}: choose one of {}", PlateMismatch::KINDS.join(", ")))?,
        };
        // A plate that is tilted the other way may carry the object off in every multisine.
        let logs = match logs(&effect, &log_settings, seed, &options) {
            Ok(logs) => logs,
            Err(e) => {
                println!("| {run} | {effect:?} | no log: {e} | | |");
                continue;
            }
        };
        if let Some(folder) = &options.out {
            let folder = folder.join(format!("run_{run}"));
            std::fs::create_dir_all(&folder)?;
            if options.held_out {
                let log = held_out(&effect, &log_settings, seed, &options)?;
                std::fs::write(folder.join("held_out.csv"), log.csv())?;
            }
            for (log, name) in logs.iter().zip(["multisine.csv", "experiment_1.csv", "experiment_3.csv"]) {
                std::fs::write(folder.join(name), log.csv())?;
            }
            std::fs::write(folder.join("truth.json"), serde_json::to_string_pretty(&effect)?)?;
            continue;
        }
        let record = |log: PlateLog| -> anyhow::Result<Record> {
            let columns = log.by_name();
            Ok(Record::from_columns(&log.name, log.t, columns, &system, &RecordSettings::default())?)
        };
        let records = logs.into_iter().map(record).collect::<anyhow::Result<Vec<Record>>>()?;
        let validate = if options.held_out {
            vec![record(held_out(&effect, &log_settings, seed, &options)?)?]
        } else {
            Vec::new()
        };
        let report = diagnose(&system, &records, &validate, &settings, &mut |_| ())?;
        let hidden: Vec<Option<Cause>> = cause(&effect).map(Some).into_iter().collect();
        let score = Score::of_causes(&hidden, &report).name();
        println!("| {run} | {effect:?} | {} | {score} | {:.1} |", named(&report), report.seconds);
        if options.full {
            println!("\n{}\n", diagnosis_text(&report, None));
        }
        *scores.entry(effect.kind()).or_default().entry(score).or_default() += 1;
    }
    if options.out.is_none() {
        println!("\n| hidden | scores |\n|---|---|");
        for (kind, counts) in scores {
            let counts: Vec<String> = counts.iter().map(|(score, count)| format!("{count} {score}")).collect();
            println!("| {kind} | {} |", counts.join(", "));
        }
    }
    Ok(())
}
