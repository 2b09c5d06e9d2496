//! `bracketry analyze`.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::Analysis;
use bracketry::lie::observability::{IdentifiabilityOptions, ObservabilityReport};
use bracketry::lie::parameters::{ParameterOptions, ParameterRange};
use bracketry::lie::{AnalysisError, AnalysisOptions, identifiability, parameter_cases, parameter_map};
use bracketry::report::Figure;
use bracketry::report::analysis as report;
use bracketry::report::identifiability::{identifiability_json, identifiability_text};
use bracketry::report::parameters::{
    parameter_figure, parameter_json, parameter_map_json, parameter_map_text, parameter_text,
};
use bracketry::system::System;
use clap::{Args, ValueEnum};

use super::from_rest;
use super::limits::TimeLimit;
use super::output::{PageArgs, TextReport, folder, json, line, listed, print, save_figures, write};
use super::progress::spinner;
use super::style::error;
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 8] = [
    ("Analyze a model", "bracketry analyze models/plate_published.toml"),
    ("At another point, as Markdown", "bracketry analyze models/cart_pole.toml --at th=pi --markdown"),
    ("Brackets written out", "bracketry analyze models/unicycle.toml --bracket \"[g1,g2]\""),
    ("Inertias for which the verdicts change", "bracketry analyze models/spacecraft.toml --parameters J1,J2,J3"),
    (
        "The same as a map over two parameters",
        "bracketry analyze models/cart_pole.toml --map l=0.1..1,m=0.05..1 --out out",
    ),
    (
        "Local and global identifiability of the parameters",
        "bracketry analyze model.toml --identifiability --known-initial x1=0",
    ),
    (
        "Rest states that are reachable under dry friction",
        "bracketry analyze models/shaken_table.toml --from-rest --bounds \"der(X,2)=-4..4\"",
    ),
    ("Write report, affine model, and figures to a folder", "bracketry analyze models/cart_pole.toml --out out"),
];

/// Format of the report on standard output.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Plain text
    Text,
    /// Markdown with LaTeX formulas
    Markdown,
    /// A LaTeX document
    Latex,
    /// One JSON object, as --json
    Json,
}

/// Arguments of `analyze`.
#[derive(Args)]
pub(crate) struct AnalyzeArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    /// Point for local statements instead of the model's, such as x=0.1,th=pi/2; unnamed states and inputs are 0
    #[arg(long, value_name = "NAME=VALUE,…")]
    at: Option<String>,
    /// Bracket to print, such as "[g1,[f,g1]]"; f is the drift, and g1, g2, … or the names of the inputs are the input fields;
    /// may be repeated
    #[arg(long = "bracket", value_name = "BRACKET")]
    brackets: Vec<String>,
    /// Function of states and parameters to test: do the outputs determine it if the parameters are unknown? May be
    /// repeated
    #[arg(long, value_name = "EXPR")]
    determines: Vec<String>,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
    /// Report which rest states bounded inputs can reach, under dry friction, from the rest state at the point
    #[arg(long, conflicts_with_all = ["brackets", "determines", "markdown", "format", "parameters", "identifiability"])]
    from_rest: bool,
    /// Bounds of inputs, of their derivatives, and of states, such as "der(X,2)=-4..4,theta=-0.2..0.2", for --from-rest;
    /// in addition to the ranges of the model
    #[arg(long, value_name = "NAME=LOW..HIGH,…", allow_hyphen_values = true, requires = "from_rest")]
    bounds: Option<String>,
    /// Treat these parameters as symbolic ("symbolic": all) and list the values at which verdicts change
    #[arg(long, value_name = "NAME,…", conflicts_with_all = ["at", "brackets", "determines", "markdown", "format"])]
    parameters: Option<String>,
    /// Map over two parameters, such as a=0..2,b=-1..1, the others at their values; with --from-rest over two bounds, such as
    /// "der(X,2)=1..6,theta=0.1..0.5", about the values at rest; the figure goes to --out
    #[arg(long, value_name = "A=LOW..HIGH,B=LOW..HIGH", allow_hyphen_values = true,
        conflicts_with_all = ["brackets", "determines", "markdown", "format", "parameters"])]
    map: Option<String>,
    /// Local and global identifiability of parameters and initial states, and identifiable combinations
    #[arg(long, conflicts_with_all = ["at", "brackets", "determines", "markdown", "format", "parameters", "map"])]
    identifiability: bool,
    /// State whose initial value is known, as x or x=0, for --identifiability; comma-separated; may be repeated
    #[arg(long, value_name = "STATE[=VALUE],…", value_delimiter = ',', requires = "identifiability")]
    known_initial: Vec<String>,
    /// Input that is an unknown function of time, for --identifiability; may be repeated
    #[arg(long = "unknown-input", value_name = "INPUT", value_delimiter = ',', requires = "identifiability")]
    unknown_inputs: Vec<String>,
    /// Cells along each axis of the map
    #[arg(long, value_name = "N", default_value_t = 40, requires = "map")]
    cells: usize,
    /// Maximum number of simultaneous conditions on parameters
    #[arg(long, value_name = "N", default_value_t = 2)]
    conditions: usize,
    /// Format of the report on standard output
    #[arg(long, value_enum, default_value = "text", conflicts_with = "json")]
    format: Format,
    /// The same as --format markdown
    #[arg(long, conflicts_with_all = ["json", "format"])]
    markdown: bool,
    #[command(flatten)]
    page: PageArgs,
}

impl AnalyzeArgs {
    fn format(&self, output: &CommonArgs) -> Format {
        match (output.json, self.markdown) {
            (true, _) => Format::Json,
            (_, true) => Format::Markdown,
            _ => self.format,
        }
    }
}

/// Prints what the inputs of a model reach.
pub(crate) fn analyze(args: &AnalyzeArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    args.page.check(output)?;
    let mut system = output.limits.read(&args.model)?;
    if args.from_rest {
        if let Some(at) = &args.at {
            system.point = Some(bracketry::point(&mut system, at).context("--at")?);
        }
        let request = from_rest::Request {
            model: &args.model,
            bounds: args.bounds.as_deref(),
            map: args.map.as_deref(),
            cells: args.cells,
            time_limit: args.time_limit.get(),
            page: args.page,
        };
        return from_rest::run(&system, &request, output);
    }
    if args.identifiability {
        return identifiable(&system, args, output);
    }
    if let Some(parameters) = &args.parameters {
        return cases(&system, parameters, args, output);
    }
    if let Some(map) = &args.map {
        anyhow::ensure!(args.at.is_none(), "--at cannot be used with --map unless --from-rest is given");
        return cells(&system, map, args, output);
    }
    if let Some(at) = &args.at {
        system.point = Some(bracketry::point(&mut system, at).context("--at")?);
    }
    let options = AnalysisOptions {
        brackets: args.brackets.clone(),
        determined: args.determines.clone(),
        time_limit: Some(args.time_limit.get()),
        ..AnalysisOptions::default()
    };
    let progress = spinner("brackets and ranks");
    let analysis = match bracketry::analyze(&system, &options) {
        // What the inputs reach is undecided.
        Err(AnalysisError::Affine(why)) => {
            progress.finish_and_clear();
            error(&format!("{}: {why}", args.model.display()));
            return Ok(Outcome::Negative);
        }
        found => found.with_context(|| args.model.display().to_string())?,
    };
    progress.finish_and_clear();
    if let Some(dir) = &output.out {
        args.page.open(&save_page(&analysis, dir)?);
    }
    let format = args.format(output);
    match format {
        Format::Json => print(&json(&report::json(&analysis))?)?,
        Format::Markdown => print(&report::markdown(&analysis))?,
        Format::Latex => print(&report::latex(&analysis))?,
        Format::Text => print(&report::text(&analysis))?,
    }
    if let (Some(dir), Format::Text) = (&output.out, format) {
        line(&format!("written to {}: {FILES}", dir.display()))?;
    }
    Ok(if answered(&analysis, args) { Outcome::Done } else { Outcome::Negative })
}

/// Prints which parameters and initial states the outputs determine.
fn identifiable(system: &System, args: &AnalyzeArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let options = IdentifiabilityOptions {
        known_initial: args.known_initial.clone(),
        unknown_inputs: args.unknown_inputs.clone(),
        time_limit: Some(args.time_limit.get()),
        ..IdentifiabilityOptions::default()
    };
    let progress = spinner("power series and polynomial equations");
    let report = identifiability(system, &options).with_context(|| args.model.display().to_string())?;
    progress.finish_and_clear();
    let (text, value) = (identifiability_text(&report), json(&identifiability_json(&report))?);
    if let Some(dir) = &output.out {
        let title = format!("Identifiability of {}", system.name);
        let (text, json, figures) = (&*text, &*value, Vec::new());
        TextReport { name: "identifiability", title, text, json, figures, system }.save(dir, args.page)?;
    }
    print(if output.json { &value } else { &text })?;
    Ok(if report.decided(options.global) { Outcome::Done } else { Outcome::Negative })
}

fn parameter_options(args: &AnalyzeArgs) -> anyhow::Result<ParameterOptions> {
    anyhow::ensure!(args.conditions > 0, "--conditions 0: give the number of conditions of a case, at least 1");
    Ok(ParameterOptions {
        conditions: args.conditions,
        time_limit: Some(args.time_limit.get()),
        ..ParameterOptions::default()
    })
}

/// Prints for which values of parameters the verdicts change.
fn cases(system: &System, names: &str, args: &AnalyzeArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let mut options = parameter_options(args)?;
    if !["symbolic", "all"].contains(&names) {
        options.parameters = names.split(',').map(|s| s.trim().to_owned()).collect();
    }
    let progress = spinner("ranks and minors");
    let report = parameter_cases(system, &options).with_context(|| args.model.display().to_string())?;
    progress.finish_and_clear();
    let (text, value) = (parameter_text(&report), json(&parameter_json(&report))?);
    if let Some(dir) = &output.out {
        let title = format!("Cases of the parameters of {}", system.name);
        let (text, json, figures) = (&*text, &*value, Vec::new());
        TextReport { name: "parameters", title, text, json, figures, system }.save(dir, args.page)?;
    }
    print(if output.json { &value } else { &text })?;
    Ok(if report.is_complete() { Outcome::Done } else { Outcome::Negative })
}

/// Prints verdicts over two parameters, and draws them.
fn cells(system: &System, map: &str, args: &AnalyzeArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let ranges = ParameterRange::two(map).context("--map")?;
    let progress = spinner("cells of the map");
    let found = parameter_map(system, &ranges, args.cells, &parameter_options(args)?)
        .with_context(|| args.model.display().to_string())?;
    progress.finish_and_clear();
    let (text, value) = (parameter_map_text(&found), json(&parameter_map_json(&found))?);
    if let Some(dir) = &output.out {
        let title = format!("Verdicts on {} over two parameters", system.name);
        let drawing = parameter_figure(&system.all_quantities(), &found).draw();
        let figures = vec![Figure::new("parameter_map", "Verdicts over two parameters", drawing)];
        let (text, json) = (&*text, &*value);
        TextReport { name: "parameter_map", title, text, json, figures, system }.save(dir, args.page)?;
    }
    print(if output.json { &value } else { &text })?;
    Ok(if found.report.is_complete() { Outcome::Done } else { Outcome::Negative })
}

/// Whether every generic dimension is decided, what the outputs determine, and what was asked for besides.
fn answered(analysis: &Analysis, args: &AnalyzeArgs) -> bool {
    let report = &analysis.report;
    let determined = report.observability.as_ref().is_some_and(|o| o.determined.is_some());
    report.dimensions_decided()
        && report.observability.as_ref().is_none_or(ObservabilityReport::decided)
        && (args.at.is_none() || report.point_decided())
        && (args.determines.is_empty() || determined)
}

/// The page with everything.
const PAGE: &str = "analysis.html";
/// What [`save_page`] writes.
const FILES: &str = "analysis.html, analysis.json, analysis.txt, analysis.md, affine.toml, and the figures growth and reach (svg and png)";

/// Writes report and affine model.
pub(crate) fn save(analysis: &Analysis, dir: &Path) -> anyhow::Result<()> {
    folder(dir)?;
    write(&dir.join("analysis.json"), &json(&report::json(analysis))?)?;
    write(&dir.join("analysis.txt"), &report::text(analysis))?;
    write(&dir.join("analysis.md"), &report::markdown(analysis))?;
    write(&dir.join("affine.toml"), &analysis.affinization.system.to_toml()?)?;
    Ok(())
}

/// [`save`] with figures and the page; gives the page.
fn save_page(analysis: &Analysis, dir: &Path) -> anyhow::Result<PathBuf> {
    save(analysis, dir)?;
    let mut files = listed(&[
        ("analysis.txt", "the report as text"),
        ("analysis.md", "the report with formulas, as Markdown"),
        ("analysis.json", "all results, for programs"),
        ("affine.toml", "the affine model"),
    ]);
    let figures = report::figures(analysis);
    files.extend(save_figures(&figures, dir));
    let page = dir.join(PAGE);
    write(&page, &report::page(analysis, &figures, &files))?;
    Ok(page)
}
