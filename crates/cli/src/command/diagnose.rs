//! `bracketry diagnose`: what a model gets wrong, by name, from measured data.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use bracketry::Diagnosis;
use bracketry::diagnose::{
    DiagnosisSettings, GainSettings, Note, Record, RecordSettings, Report, RivalModel, StudySettings, diagnose,
    read_record, reference_candidates, significant,
};
use bracketry::experiment::comparable;
use bracketry::lie::analysis::RankChange;
use bracketry::report::NextExperiment;
use bracketry::sim::Hold;
use bracketry::system::System;
use clap::Args;

use super::file_kind::{FileKind, Given};
use super::interrupt::ended_by_user;
use super::limits::seconds;
use super::output::{PageArgs, folder, json, line, listed, print, save_figures, write};
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

/// The page with everything.
const PAGE: &str = "diagnosis.html";
/// Most next experiments that are named: each takes away one rival, and mostly others with it.
const MOST_NEXT: usize = 3;

/// Arguments of `diagnose`.
#[derive(Args)]
pub(crate) struct DiagnoseArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    model: PathBuf,
    /// Measured runs (CSV or NPZ): a column t with the time, one per measured state or output, one per input
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
    /// Length of the windows in time; by default chosen from the data
    #[arg(long, allow_negative_numbers = true, value_name = "S")]
    window: Option<f64>,
    /// Horizons of time at which predictions are compared; by default chosen from the data
    #[arg(long, value_name = "S,…", value_delimiter = ',', allow_negative_numbers = true)]
    horizon: Vec<f64>,
    #[command(flatten)]
    page: PageArgs,
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
    args.page.check(output)?;
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
        end_search: ended_by_user("the search for causes ends")?,
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
    let next_experiments = match &extended_model {
        Some(extended) => next_experiments(&args.model, extended, &report, &records)?,
        None => Vec::new(),
    };
    let diagnosis = Diagnosis { report, ranks, extended_model, next_experiments };
    if let Some(dir) = &output.out {
        progress.set_message("drawing");
        write_files(dir, &diagnosis)?;
        args.page.open(&dir.join(PAGE));
    }
    progress.finish_and_clear();
    if output.json {
        print(&json(&diagnosis)?)?;
    } else {
        print(&diagnosis.to_string())?;
        match &output.out {
            Some(dir) => line(&format!("written to {}: {PAGE} with everything", dir.display()))?,
            None => {
                line(
                    "(--out DIR writes a page with everything, the figures, and the extended model, if there is one)",
                )?;
            }
        }
    }
    Ok(outcome(&diagnosis.report))
}

/// Writes the models of rivals beside the extended one, and says how to design the experiments that tell them from it.
fn next_experiments(
    model: &Path,
    extended: &Path,
    report: &Report,
    records: &[Record],
) -> anyhow::Result<Vec<NextExperiment>> {
    let Some(found) = &report.evidence.model else { return Ok(Vec::new()) };
    let mut next = Vec::new();
    for RivalModel { cause, rival, model: other } in report.evidence.rivals.iter().take(MOST_NEXT) {
        // Delays of sensors stand in no equation.
        let is_whole = found.notes.is_empty() && other.notes.is_empty();
        let limits = limits(&found.system, records);
        let (true, Some(limits)) = (is_whole && comparable([&found.system, &other.system]).is_ok(), limits) else {
            continue;
        };
        let path = extended.with_file_name(format!("rival_{}.toml", next.len() + 1));
        write(&path, &other.to_toml()?)?;
        let duration = |r: &Record| r.times.last().zip(r.times.first()).map_or(0.0, |(end, start)| end - start);
        let longest = records.iter().map(duration).fold(0.0, f64::max);
        let command = format!(
            "bracketry experiment {} --tell {},{}{limits} --duration {}{}",
            model.display(),
            extended.display(),
            path.display(),
            significant(longest, 3),
            measured(records)
        );
        next.push(NextExperiment { cause: *cause, rival: *rival, command });
    }
    Ok(next)
}

/// The options with what was measured, and with the noise that was found in it.
fn measured(records: &[Record]) -> String {
    let columns = records.first().and_then(|r| r.audit.as_ref()).map_or(&[][..], |a| &a.columns[..]);
    let measured: Vec<_> = columns.iter().filter(|c| !c.input).collect();
    let names: Vec<&str> = measured.iter().map(|c| c.name.as_str()).collect();
    let known = measured.iter().filter_map(|c| Some((&c.name, c.noise.filter(|n| *n > 0.0)?)));
    let noise: Vec<String> = known.map(|(name, std)| format!("{name}={}", significant(std, 3))).collect();
    let option =
        |name: &str, entries: String| if entries.is_empty() { entries } else { format!(" --{name} {entries}") };
    option("measure", names.join(",")) + &option("noise", noise.join(","))
}

/// The option with the range of every input in the data, its value at rest included, unless the model has one; none where an input never moves.
fn limits(system: &System, records: &[Record]) -> Option<String> {
    let rest = system.point_values().map_or_else(|| vec![0.0; system.inputs.len()], |(_, u)| u);
    let mut entries = Vec::new();
    for (j, name) in system.input_names().iter().enumerate() {
        if system.range_of_input(j).is_some_and(|(low, high)| low.is_finite() && high.is_finite()) {
            continue;
        }
        let values = records.iter().filter_map(|r| r.inputs.get(j)).flat_map(|s| s.values.iter().copied());
        let (low, high) = values.fold((rest[j], rest[j]), |(low, high), v| (low.min(v), high.max(v)));
        if low == high {
            return None;
        }
        entries.push(format!("{name}={}..{}", significant(low, 3), significant(high, 3)));
    }
    Some(if entries.is_empty() { String::new() } else { format!(" --limits {}", entries.join(",")) })
}

fn outcome(report: &Report) -> Outcome {
    let is_cut = report.notes.iter().any(|note| matches!(note, Note::TimeLimit { .. } | Note::Interrupted { .. }));
    if report.verdict.is_conclusive() && !is_cut { Outcome::Done } else { Outcome::Negative }
}

/// Writes report and figures.
fn write_files(dir: &Path, diagnosis: &Diagnosis) -> anyhow::Result<()> {
    folder(dir)?;
    write(&dir.join("diagnosis.json"), &json(diagnosis)?)?;
    write(&dir.join("diagnosis.txt"), &diagnosis.to_string())?;
    let figures = diagnosis.figures();
    let mut files = listed(&[("diagnosis.txt", "the report as text"), ("diagnosis.json", "all results, for programs")]);
    if let Some(model) = diagnosis.extended_model.as_ref().and_then(|path| path.file_name()) {
        files.push((model.to_string_lossy().into_owned(), "the extended model".to_owned()));
    }
    let rivals = 1..=diagnosis.next_experiments.len();
    files.extend(rivals.map(|k| (format!("rival_{k}.toml"), "the model with a rival of a cause".to_owned())));
    files.extend(save_figures(&figures, dir));
    write(&dir.join(PAGE), &diagnosis.page(&figures, &files))
}
