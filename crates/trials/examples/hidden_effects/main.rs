//! Hides effects in logs of a slider, diagnoses them and counts what was named:
//! `cargo run --release -p bracketry-trials --example hidden_effects --features measure -- --runs 200 --seed 1 --measured xv --size 0.1 --effect any`
//!
//! `--help` lists the options; `--export DIR` writes the logs, models and truths for other programs instead.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod export;
mod tally;

use bracketry_diagnose::DiagnosisSettings;
use bracketry_trials::{Choice, SliderEffect, SliderSensors, SliderTrial};
use clap::Parser;
use rayon::prelude::*;
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;
use tally::{Row, table};

/// Hides effects in logs of a slider, diagnoses them and counts what was named.
#[derive(Parser)]
struct Options {
    /// Number of logs.
    #[arg(long, default_value_t = 40)]
    runs: u64,
    /// Seed of the first log; the next ones count up.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What is measured: xv or x.
    #[arg(long, default_value = "xv", value_parser = sensors)]
    measured: SliderSensors,
    /// Root mean square of the effect's force relative to the drive's.
    #[arg(long, default_value_t = 0.1)]
    size: f64,
    /// any, none, pair, further, outside, or the name of one effect.
    #[arg(long, default_value = "any", value_parser = choice)]
    effect: Choice,
    /// Sampling, noise, excitation, masses and sizes at random as well.
    #[arg(long)]
    general: bool,
    /// Length of the windows, s; by default chosen from the data.
    #[arg(long)]
    window: Option<f64>,
    /// Diagnose several logs at the same time: quicker as a whole, slower by verdict.
    #[arg(long)]
    parallel: bool,
    /// Write one JSON object per log into this file.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Write logs, models and truths into this directory and diagnose nothing.
    #[arg(long)]
    export: Option<PathBuf>,
}

fn sensors(text: &str) -> Result<SliderSensors, String> {
    match text {
        "xv" => Ok(SliderSensors::PositionAndVelocity),
        "x" => Ok(SliderSensors::Position),
        _ => Err("xv or x".to_owned()),
    }
}

fn choice(text: &str) -> Result<Choice, String> {
    Ok(match text {
        "any" => Choice::Any,
        "none" => Choice::Nothing,
        "pair" => Choice::Pair,
        "further" => Choice::Further,
        "outside" => Choice::Outside,
        name => Choice::Only(SliderEffect::from_name(name).ok_or("any, none, pair, further, outside or an effect")?),
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = Options::parse();
    let trials: Vec<SliderTrial> = (options.seed..options.seed + options.runs)
        .map(|seed| SliderTrial::draw(options.effect, options.measured, options.size, options.general, seed))
        .collect();
    if let Some(directory) = &options.export {
        return export::export(&trials, directory);
    }
    let (begin, done) = (Instant::now(), AtomicU64::new(0));
    let mut settings = DiagnosisSettings::default();
    settings.study.window = options.window;
    let file = options.json.as_ref().map(File::create).transpose()?.map(Mutex::new);
    let run = |trial: &SliderTrial| {
        let start = Instant::now();
        let outcome = trial.run(&settings);
        let row = Row::new(trial, outcome, start.elapsed().as_secs_f64());
        if let Some(file) = &file {
            writeln!(file.lock().unwrap_or_else(PoisonError::into_inner), "{}", row.json)?;
        }
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        eprintln!("{count:4}/{} {:5.0} s  {row}", options.runs, begin.elapsed().as_secs_f64());
        Ok(row)
    };
    let rows: Result<Vec<Row>, std::io::Error> =
        if options.parallel { trials.par_iter().map(run).collect() } else { trials.iter().map(run).collect() };
    print!("{}", table(&rows?));
    Ok(())
}
