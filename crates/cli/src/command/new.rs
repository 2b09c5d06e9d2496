//! `bracketry new`: a commented model of one's own, with a scenario and a problem that run as they stand.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};
use serde_json::json as object;

use super::output::{folder, json, line, print};
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 2] = [
    ("Start with a mass on a spring", "bracketry new mass"),
    ("Two tanks with a delay, in a folder", "bracketry new plant --template tanks --out plant"),
];

/// Template for the files.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Template {
    /// A mass on a spring, pushed by a force: linear, one input
    Spring,
    /// A carriage on a rail with dry friction, simulated exactly
    Friction,
    /// A pendulum to be swung up by a weak motor
    Pendulum,
    /// A vehicle that cannot move sideways: two inputs, no drift term
    Vehicle,
    /// Two tanks, a pump that cannot run backward, and a delay
    Tanks,
}

impl Template {
    /// Model, scenario and problem.
    fn texts(self) -> [&'static str; 3] {
        macro_rules! files {
            ($name:literal) => {
                [
                    include_str!(concat!("new/", $name, ".toml")),
                    include_str!(concat!("new/", $name, "_scenario.toml")),
                    include_str!(concat!("new/", $name, "_problem.toml")),
                ]
            };
        }
        match self {
            Self::Spring => files!("spring"),
            Self::Friction => files!("friction"),
            Self::Pendulum => files!("pendulum"),
            Self::Vehicle => files!("vehicle"),
            Self::Tanks => files!("tanks"),
        }
    }

    /// What its sensors measure, with noise of a thousandth or so of what they show, as `simulate --noise` takes it.
    fn sensors(self) -> &'static str {
        match self {
            Self::Spring => "position=0.0005",
            Self::Friction => "x=0.0005",
            Self::Pendulum => "angle=0.001",
            Self::Vehicle => "x=0.002,y=0.002",
            Self::Tanks => "level=0.01",
        }
    }
}

/// Arguments of `new`. The folder of --out is the current one if it is absent.
#[derive(Args)]
pub(crate) struct NewArgs {
    /// Name of the model and of its file; letters, digits, _, and -
    name: String,
    /// Template for the files
    #[arg(long, value_enum, default_value = "spring")]
    template: Template,
}

/// Stands for the name in templates.
const NAME: &str = "@NAME@";

/// Writes model, scenario, and problem.
pub(crate) fn run(args: &NewArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let name = checked(&args.name)?;
    let dir = output.out.clone().unwrap_or_default();
    let files: Vec<PathBuf> =
        ["", "_scenario", "_problem"].iter().map(|end| dir.join(format!("{name}{end}.toml"))).collect();
    if let Some(taken) = files.iter().find(|f| f.exists()) {
        anyhow::bail!(
            "{}: already exists and was not changed\n   = choose another name, or remove the file",
            taken.display()
        );
    }
    if !dir.as_os_str().is_empty() {
        folder(&dir)?;
    }
    for (path, text) in files.iter().zip(args.template.texts()) {
        create(path, &text.replace(NAME, name))?;
    }
    let [model, scenario, problem] = [0, 1, 2].map(|k| files[k].display().to_string());
    let sensors = args.template.sensors();
    let next = [
        format!("bracketry analyze {model}"),
        format!("bracketry simulate {model} --scenario {scenario} --noise {sensors} --out out"),
        format!("bracketry control {problem} --out out"),
        // The inputs of the scenarios are smooth.
        format!("bracketry diagnose {model} out/measured.csv --hold linear --out out"),
    ];
    if output.json {
        print(&json(&object!({"model": model, "scenario": scenario, "problem": problem, "next": next}))?)?;
        return Ok(Outcome::Done);
    }
    line(&format!("written: {model}, {scenario}, {problem}"))?;
    line("next:")?;
    for command in next {
        line(&format!("  {command}"))?;
    }
    Ok(Outcome::Done)
}

/// Writes a file that does not exist.
fn create(path: &Path, text: &str) -> anyhow::Result<()> {
    let file = std::fs::File::create_new(path);
    file.and_then(|mut f| std::io::Write::write_all(&mut f, text.as_bytes()))
        .with_context(|| format!("cannot write {}", path.display()))
}

/// A name that can be the name of a file everywhere; an ending .toml is left out.
fn checked(name: &str) -> anyhow::Result<&str> {
    let stem = name.strip_suffix(".toml").unwrap_or(name);
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    anyhow::ensure!(
        !stem.is_empty() && !stem.starts_with('-') && stem.len() <= 100 && stem.chars().all(fits),
        "`{name}` is not a valid model name\n   = use letters, digits, _, and -, as in mass_2; --out DIR names the folder"
    );
    Ok(stem)
}
