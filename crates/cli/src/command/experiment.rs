//! `bracketry experiment`: the inputs of the next experiment.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::experiment::{Discrimination, ExperimentOptions, Identification, Limit, identify, tell};
use bracketry::plot::{Drawing, PlotError};
use bracketry::report::experiments::{
    discrimination_figure, discrimination_json, discrimination_table, discrimination_text, experiment_inputs,
    identification_figure, identification_json, identification_table, identification_text,
};
use bracketry::steer::from_rest::Bound;
use bracketry::symbolic::{Rational, closest_name};
use bracketry::system::System;
use clap::Args;

use super::file_kind::{FileKind, Given};
use super::limits::TimeLimit;
use super::output::{csv, figure, folder, json, line, print, write};
use super::progress::spinner;
use super::seed::seed;
use super::simulate::sensor;
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    (
        "Tell two models of one system apart",
        "bracketry experiment cart.toml --tell viscous.toml,quadratic.toml --limits u=-2..2,x=-1..1 --duration 8 --out out",
    ),
    (
        "The model, or the same with another value of a parameter",
        "bracketry experiment cart.toml --tell c=0.8 --limits u=-2..2 --duration 8 --noise v=0.01",
    ),
    (
        "Identify parameters as well as possible",
        "bracketry experiment cart.toml --parameters m,c --limits u=-2..2 --duration 8 --out out",
    ),
];

/// Arguments of `experiment`.
#[derive(Args)]
#[command(group(clap::ArgGroup::new("aim").required(true).args(["tell", "parameters"])))]
pub(crate) struct ExperimentArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    model: PathBuf,
    /// Two explanations to tell apart: model files, or values of a parameter of MODEL; one alone is told from MODEL
    #[arg(long, value_name = "A,B", value_delimiter = ',', conflicts_with = "parameters")]
    tell: Vec<String>,
    /// Parameters of MODEL to identify
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    parameters: Vec<String>,
    /// Limits of inputs, of their rates, and of states, such as "u=-1..1,der(u)=-4..4,x=-0.2..0.2" [default for inputs: their ranges]
    #[arg(long, value_name = "NAME=LOW..HIGH,…", allow_hyphen_values = true)]
    limits: Option<String>,
    /// Duration
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    duration: f64,
    /// Time between two samples [default: a two-hundredth of the duration]
    #[arg(long, value_name = "DT", allow_negative_numbers = true)]
    sample: Option<f64>,
    /// What is measured: outputs or states [default: the outputs of the models, or else their states]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    measure: Vec<String>,
    /// Standard deviations of the noise of measured columns [default: 1 % of their limits or ranges]
    #[arg(long, value_name = "NAME=STD,…", value_delimiter = ',', value_parser = sensor)]
    noise: Vec<(String, f64)>,
    /// Parameters that are known, so that no refit changes them
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', requires = "tell")]
    fix: Vec<String>,
    /// Random inputs from which the optimization starts, in addition to simple ones
    #[arg(long, value_name = "N", default_value_t = 6, allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(..=1000))]
    starts: u16,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
    /// Seed of random starts
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 1, value_parser = seed)]
    seed: u64,
}

impl ExperimentArgs {
    pub(crate) fn files(&self) -> Vec<Given> {
        let explanations = self.tell.iter().filter(|t| is_file(t)).map(PathBuf::from);
        let models = std::iter::once(self.model.clone()).chain(explanations);
        models.map(|path| Given::new(&path, FileKind::Model)).collect()
    }
}

/// Designs the experiment, prints the report, and writes the files.
pub(crate) fn run(args: &ExperimentArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let path = args.model.display().to_string();
    let system = output.limits.read(&args.model)?;
    system.check_denominators().with_context(|| path.clone())?;
    let limits = args.limits.as_deref().map_or(Ok(Vec::new()), Bound::list).context("--limits")?;
    let options = ExperimentOptions {
        sample: args.sample,
        limits: limits.iter().map(|b| Limit::new(&b.name, b.low, b.high)).collect(),
        measured: args.measure.clone(),
        noise: args.noise.clone(),
        fixed: fixed(args),
        starts: usize::from(args.starts),
        seed: args.seed,
        time_limit: Some(args.time_limit.get()),
        stop: system.pool.stop_flag().clone(),
        ..ExperimentOptions::lasting(args.duration)
    };
    let progress = spinner("designing the experiment");
    if args.tell.is_empty() {
        let found = identify(&system, &args.parameters, &options)?;
        progress.finish_and_clear();
        return report(&Found::of_parameters(&found)?, output);
    }
    let [(a, first), (b, second)] = explanations(args, &system, output)?;
    let found = tell([(&a, &first), (&b, &second)], &options)?;
    progress.finish_and_clear();
    report(&Found::of_explanations(&found)?, output)
}

/// A result in all its forms.
struct Found {
    text: String,
    json: String,
    inputs: (Vec<String>, Vec<Vec<f64>>),
    expected: (Vec<String>, Vec<Vec<f64>>),
    figure: Result<Drawing, PlotError>,
    is_positive: bool,
}

impl Found {
    fn of_parameters(found: &Identification) -> anyhow::Result<Self> {
        Ok(Self {
            text: identification_text(found),
            json: json(&identification_json(found))?,
            inputs: experiment_inputs(&found.design),
            expected: identification_table(found),
            figure: identification_figure(found),
            is_positive: found.is_identified(),
        })
    }

    fn of_explanations(found: &Discrimination) -> anyhow::Result<Self> {
        Ok(Self {
            text: discrimination_text(found),
            json: json(&discrimination_json(found))?,
            inputs: experiment_inputs(&found.design),
            expected: discrimination_table(found),
            figure: discrimination_figure(found),
            is_positive: found.resolves(),
        })
    }
}

fn report(found: &Found, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let mut written = String::new();
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("experiment.txt"), &found.text)?;
        write(&dir.join("experiment.json"), &found.json)?;
        for (name, (header, rows)) in [("inputs.csv", &found.inputs), ("expected.csv", &found.expected)] {
            csv(&dir.join(name), header, rows.iter().map(Vec::as_slice))?;
        }
        let drawn = figure(&found.figure, &dir.join("experiment"));
        let drawn = if drawn { ", experiment.svg, experiment.png" } else { "" };
        written =
            format!("written to {}: experiment.txt, experiment.json, inputs.csv, expected.csv{drawn}", dir.display());
    }
    print(if output.json { &found.json } else { &found.text })?;
    if !written.is_empty() && !output.json {
        line(&written)?;
    }
    Ok(if found.is_positive { Outcome::Done } else { Outcome::Negative })
}

/// Whether an explanation is a file, not a value of a parameter.
fn is_file(text: &str) -> bool {
    !text.contains('=') || Path::new(text).is_file()
}

/// The parameters that are known, and those of which an explanation is a value: these are to be told, not fitted.
fn fixed(args: &ExperimentArgs) -> Vec<String> {
    let mut names = args.fix.clone();
    for name in args.tell.iter().filter_map(|t| value_of(t)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The parameter of which an explanation is a value.
fn value_of(text: &str) -> Option<String> {
    text.split_once('=').filter(|_| !is_file(text)).map(|(name, _)| name.trim().to_owned())
}

/// The two explanations with their names.
fn explanations(args: &ExperimentArgs, system: &System, output: &CommonArgs) -> anyhow::Result<[(String, System); 2]> {
    let own = (stem(&args.model), system.clone());
    let read = |text: &String| explanation(text, system, output);
    match &args.tell[..] {
        [other] => Ok([own, read(other)?]),
        [a, b] => Ok([read(a)?, read(b)?]),
        more => anyhow::bail!(
            "--tell: {} explanations are given\n   = give two, or one that is told from MODEL",
            more.len()
        ),
    }
}

fn explanation(text: &str, system: &System, output: &CommonArgs) -> anyhow::Result<(String, System)> {
    if is_file(text) {
        let path = Path::new(text);
        let model = output.limits.read(path)?;
        model.check_denominators().with_context(|| text.to_owned())?;
        return Ok((stem(path), model));
    }
    let (name, value) = text.split_once('=').unwrap_or((text, ""));
    let (name, value) = (name.trim(), value.trim());
    let value: Option<Rational> = value.parse::<f64>().ok().and_then(|v| Rational::try_from(v).ok());
    let value = value.with_context(|| format!("--tell {text}: write a parameter, =, and a number, or a model file"))?;
    let mut model = system.clone();
    if !model.set_parameter(name, value) {
        let names = system.parameter_names();
        let near = closest_name(name, names.iter().map(String::as_str));
        let remedy = near.map_or_else(|| format!("there are {}", names.join(", ")), |n| format!("did you mean `{n}`?"));
        anyhow::bail!("--tell {text}: `{name}` is not a parameter of the model\n   = {remedy}");
    }
    Ok((text.to_owned(), model))
}

/// The name of a file without folder and ending.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| path.display().to_string(), |s| s.to_string_lossy().into_owned())
}
