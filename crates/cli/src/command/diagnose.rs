//! `bracketry diagnose`: what a model gets wrong, by name, from measured data.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use bracketry::Diagnosis;
use bracketry::diagnose::{
    DiagnosisSettings, GainSettings, Note, Record, RecordSettings, Report, StudySettings, diagnose, read_record,
    reference_candidates,
};
use bracketry::lie::analysis::RankChange;
use bracketry::sim::Hold;
use bracketry::system::System;
use clap::Args;

use super::file_kind::{FileKind, Given};
use super::limits::seconds;
use super::output::{figure, folder, json, line, print, write};
use super::progress::spinner;
use super::seed::seed;
use super::simulate::HoldArg;
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 4] = [
    (
        "Inputs that are samples of a smooth signal, such as a measured force",
        "bracketry diagnose mass.toml run.csv --hold linear --out out",
    ),
    (
        "Inputs held by a digital controller, and a held-out second run",
        "bracketry diagnose models/emps.toml run.csv --validate second.csv --out out",
    ),
    ("Rename columns", "bracketry diagnose slider.toml log.csv --rename force=u,pos=x"),
    ("Fix a parameter that is known well", "bracketry diagnose slider.toml log.csv --fix m --json"),
];

/// Arguments of `diagnose`.
#[derive(Args)]
pub(crate) struct DiagnoseArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    model: PathBuf,
    /// Measured runs (CSV or NPZ): a column t in seconds, one per measured state or output, one per input
    #[arg(required = true, value_name = "DATA", value_hint = clap::ValueHint::FilePath)]
    data: Vec<PathBuf>,
    /// Model names of columns, such as force=u
    #[arg(long, value_name = "COLUMN=NAME,…", value_delimiter = ',', value_parser = renaming)]
    rename: Vec<(String, String)>,
    /// Inputs between samples [default: previous; linear for derivatives of inputs]
    #[arg(long, value_enum)]
    hold: Option<HoldArg>,
    /// Held-out runs on which the gain is measured
    #[arg(long, value_name = "DATA", num_args = 1..)]
    validate: Vec<PathBuf>,
    /// Parameters that keep their values
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    fix: Vec<String>,
    /// Length of the windows in seconds; by default chosen from the data
    #[arg(long, allow_negative_numbers = true, value_name = "S")]
    window: Option<f64>,
    /// Horizons in seconds at which predictions are compared; by default chosen from the data
    #[arg(long, value_name = "S,…", value_delimiter = ',', allow_negative_numbers = true)]
    horizon: Vec<f64>,
    /// Another model of the same system: terms of its equations that MODEL lacks become candidates
    #[arg(long, value_name = "MODEL2")]
    reference: Option<PathBuf>,
    /// End the search for causes after this many seconds in all; what was left out is reported
    #[arg(long, alias = "budget", value_name = "SECONDS", default_value = "600", allow_negative_numbers = true, value_parser = seconds)]
    pub(crate) time_limit: Duration,
    /// Largest number of causes named together
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = DiagnosisSettings::default().max_causes)]
    max_causes: usize,
    /// Seed for resampling
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = DiagnosisSettings::default().seed, value_parser = seed)]
    seed: u64,
}

impl DiagnoseArgs {
    pub(crate) fn files(&self) -> Vec<Given> {
        let models = [&self.model].into_iter().chain(&self.reference).map(|p| Given::new(p, FileKind::Model));
        models.chain(self.data.iter().chain(&self.validate).map(|p| Given::new(p, FileKind::Table))).collect()
    }
}

fn renaming(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((column, name)) if !column.trim().is_empty() && !name.trim().is_empty() => {
            Ok((column.trim().to_owned(), name.trim().to_owned()))
        }
        _ => Err("write the column's name, =, and the name in the model: q=x".to_owned()),
    }
}

/// Reads, diagnoses, and writes what was found.
pub(crate) fn run(args: &DiagnoseArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let system = output.limits.read(&args.model)?;
    system.check_denominators().with_context(|| args.model.display().to_string())?;
    let reading = RecordSettings {
        hold: args.hold.map(|hold| match hold {
            HoldArg::Previous => Hold::Previous,
            HoldArg::Linear => Hold::Linear,
        }),
        rename: args.rename.clone(),
        ..RecordSettings::default()
    };
    let progress = spinner("reading the data");
    let read = |paths: &[PathBuf]| -> Result<Vec<Record>, _> {
        paths.iter().map(|path| read_record(path, &system, &reading)).collect()
    };
    let (records, validate) = (read(&args.data)?, read(&args.validate)?);
    let settings = DiagnosisSettings {
        study: StudySettings { window: args.window, fixed: args.fix.clone(), ..StudySettings::default() },
        max_causes: args.max_causes,
        time_limit: Some(args.time_limit),
        seed: args.seed,
        candidates: match &args.reference {
            Some(path) => reference_candidates(&system, &System::read(path)?)
                .with_context(|| format!("--reference {}", path.display()))?,
            None => Vec::new(),
        },
        gain: GainSettings::with_horizons(&args.horizon),
        ..DiagnosisSettings::default()
    };
    let report =
        diagnose(&system, &records, &validate, &settings, &mut |stage| progress.set_message(stage.to_string()))?;
    let model = report.evidence.model.as_ref();
    let extended_model = match (&output.out, model) {
        (Some(dir), Some(model)) => {
            folder(dir)?;
            let path = dir.join("extended.toml");
            write(&path, &model.to_toml()?)?;
            Some(path)
        }
        _ => None,
    };
    progress.set_message("ranks of the extended model");
    let ranks = model.and_then(|model| RankChange::of_systems(&system, &model.system));
    let diagnosis = Diagnosis { report, ranks, extended_model };
    if let Some(dir) = &output.out {
        progress.set_message("drawing");
        write_files(dir, &diagnosis)?;
    }
    progress.finish_and_clear();
    if output.json {
        print(&json(&diagnosis)?)?;
    } else {
        print(&diagnosis.to_string())?;
        match &output.out {
            Some(dir) => line(&format!("written to {}", dir.display()))?,
            None => {
                line(
                    "(--out DIR writes a page with everything, the figures, and the extended model, if there is one)",
                )?;
            }
        }
    }
    Ok(outcome(&diagnosis.report))
}

fn outcome(report: &Report) -> Outcome {
    let is_cut = report.notes.iter().any(|note| matches!(note, Note::TimeLimit { .. }));
    if report.verdict.is_conclusive() && !is_cut { Outcome::Done } else { Outcome::Negative }
}

/// Writes report and figures.
fn write_files(dir: &Path, diagnosis: &Diagnosis) -> anyhow::Result<()> {
    folder(dir)?;
    write(&dir.join("diagnosis.json"), &json(diagnosis)?)?;
    write(&dir.join("diagnosis.txt"), &diagnosis.to_string())?;
    let figures = diagnosis.figures();
    write(&dir.join("diagnosis.html"), &diagnosis.page(&figures))?;
    for f in figures {
        figure(f.drawing, &dir.join(f.name));
    }
    Ok(())
}
