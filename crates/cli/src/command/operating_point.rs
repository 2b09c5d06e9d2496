//! `bracketry trim` and `bracketry linearize`.

use std::path::PathBuf;

use anyhow::Context;
use bracketry::lie::operating::{LinearizeError, LinearizeOptions, Trim, TrimOptions, TrimStatus};
use bracketry::lie::{linearize as linear_system, trim as operating_point};
use bracketry::report::operating::{linear_files, linear_json, linear_text, trim_json, trim_text};
use bracketry::system::{System, point};
use clap::Args;
use serde_json::json as object;

use super::limits::TimeLimit;
use super::output::{folder, json, line, print, write};
use super::seed::seed;
use super::{CommonArgs, Outcome};

/// Shown by the help of `trim`.
pub(crate) const TRIM_EXAMPLES: [(&str, &str); 2] = [
    ("An equilibrium near the model's point", "bracketry trim models/cart_pole.toml"),
    ("An angle with the input that holds it", "bracketry trim models/pendulum_driven.toml --fix th=1 --free tau"),
];

/// Shown by the help of `linearize`.
pub(crate) const LINEARIZE_EXAMPLES: [(&str, &str); 2] = [
    (
        "A, B, C, D, poles, zeros, distances to uncontrollability, and gains",
        "bracketry linearize models/cart_pole.toml",
    ),
    ("Files for python-control, MATLAB, and Julia", "bracketry linearize models/cart_pole.toml --out out"),
];

/// What an operating point is asked for.
#[derive(Args)]
pub(crate) struct PointArgs {
    /// Value of a state or input, such as th=pi/2; comma-separated; may be repeated
    #[arg(long = "fix", value_name = "NAME=VALUE,…")]
    fixed: Vec<String>,
    /// Input to solve for; the other inputs keep their values at the model's point; may be repeated
    #[arg(long = "free", value_name = "NAME")]
    free: Vec<String>,
    /// State whose derivative need not vanish, such as a position at constant speed; may be repeated
    #[arg(long = "moving", value_name = "STATE")]
    moving: Vec<String>,
    /// Number of random starts in addition to the model's point
    #[arg(long, default_value_t = 24, value_name = "N")]
    starts: usize,
    /// Seed of the random starts
    #[arg(long, allow_negative_numbers = true, default_value_t = 1, value_name = "N", value_parser = seed)]
    seed: u64,
}

impl PointArgs {
    fn is_asked(&self) -> bool {
        !self.fixed.is_empty() || !self.free.is_empty() || !self.moving.is_empty()
    }

    fn options(&self, system: &mut System) -> anyhow::Result<TrimOptions> {
        let split = |list: &[String]| -> Vec<String> {
            list.iter().flat_map(|s| s.split(',')).map(|s| s.trim().to_owned()).collect()
        };
        let mut options = TrimOptions {
            free: split(&self.free),
            moving: split(&self.moving),
            starts: self.starts.min(1000),
            seed: self.seed,
            ..TrimOptions::default()
        };
        if !self.fixed.is_empty() {
            let text = self.fixed.join(",");
            let at = point(system, &text).with_context(|| format!("--fix {text}"))?;
            for (k, name) in system.state_names().into_iter().chain(system.input_names()).enumerate() {
                let named = text.split(',').any(|e| e.split_once('=').is_some_and(|(n, _)| n.trim() == name));
                if named {
                    options.fixed.push((name, at.states.iter().chain(&at.inputs).copied().collect::<Vec<_>>()[k]));
                }
            }
        }
        Ok(options)
    }

    fn search(&self, system: &mut System) -> anyhow::Result<Trim> {
        let options = self.options(system)?;
        Ok(operating_point(system, &options)?)
    }
}

/// Arguments of `trim`.
#[derive(Args)]
pub(crate) struct TrimArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    #[command(flatten)]
    point: PointArgs,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
}

/// Prints an operating point; with --out, also the model at that point.
pub(crate) fn trim(args: &TrimArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let mut system = output.limits.read(&args.model)?;
    system.pool.set_deadline(output.limits.deadline());
    let found = args.point.search(&mut system).with_context(|| args.model.display().to_string())?;
    let text = trim_text(&system.name, &found);
    let value = trim_json(&system.name, &found);
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("trim.txt"), &text)?;
        write(&dir.join("trim.json"), &json(&value)?)?;
        if found.status == TrimStatus::Found {
            system.point = Some(found.point(&mut system));
            write(&dir.join("trimmed.toml"), &system.to_toml()?)?;
        }
    }
    print(&if output.json { json(&value)? } else { text })?;
    Ok(if found.status == TrimStatus::Found { Outcome::Done } else { Outcome::Negative })
}

/// Arguments of `linearize`.
#[derive(Args)]
pub(crate) struct LinearizeArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    /// Point instead of the model's, such as x=0.1,th=pi/2; unnamed states and inputs are 0
    #[arg(long, value_name = "NAME=VALUE,…", conflicts_with_all = ["fixed", "free", "moving", "trim"])]
    at: Option<String>,
    /// Linearize at the operating point that `trim` finds; implied by --fix, --free, and --moving
    #[arg(long)]
    trim: bool,
    #[command(flatten)]
    point: PointArgs,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
    /// Weights of the states in the regulator, one for all or one each
    #[arg(long, value_name = "Q,…", value_delimiter = ',', allow_negative_numbers = true)]
    state_weights: Vec<f64>,
    /// Weights of the inputs in the regulator
    #[arg(long, value_name = "R,…", value_delimiter = ',', allow_negative_numbers = true)]
    input_weights: Vec<f64>,
    /// Process noise of each state in the Kalman filter, as an intensity
    #[arg(long, value_name = "V,…", value_delimiter = ',', allow_negative_numbers = true)]
    process_noise: Vec<f64>,
    /// Noise of each output in the Kalman filter, as an intensity
    #[arg(long, value_name = "W,…", value_delimiter = ',', allow_negative_numbers = true)]
    measurement_noise: Vec<f64>,
    /// Upper limit of the Gramian integrals over time; by default infinite for a stable system
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    horizon: Option<f64>,
}

/// Prints the linear system around a point and what it tells.
pub(crate) fn linearize(args: &LinearizeArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let path = args.model.display().to_string();
    let mut system = output.limits.read(&args.model)?;
    system.pool.set_deadline(output.limits.deadline());
    if let Some(horizon) = args.horizon {
        anyhow::ensure!(horizon.is_finite() && horizon > 0.0, "--horizon {horizon}: give a positive number of seconds");
    }
    if let Some(at) = &args.at {
        system.point = Some(point(&mut system, at).with_context(|| format!("--at {at}"))?);
    } else if args.trim || args.point.is_asked() {
        let found = args.point.search(&mut system).with_context(|| path.clone())?;
        if found.status != TrimStatus::Found {
            let value = object!({"model": system.name, "trim": trim_json(&system.name, &found)});
            print(&if output.json { json(&value)? } else { trim_text(&system.name, &found) })?;
            return Ok(Outcome::Negative);
        }
        if !output.json {
            print(&trim_text(&system.name, &found))?;
        }
        system.point = Some(found.point(&mut system));
    }
    let options = LinearizeOptions {
        state_weights: args.state_weights.clone(),
        input_weights: args.input_weights.clone(),
        process_noise: args.process_noise.clone(),
        measurement_noise: args.measurement_noise.clone(),
        horizon: args.horizon,
    };
    let found = match linear_system(&system, &options) {
        Ok(found) => found,
        Err(LinearizeError::NotLinearizable(why)) => {
            let value = object!({"model": system.name, "reason": why.to_string()});
            print(&if output.json { json(&value)? } else { format!("{}: no linearization: {why}\n", system.name) })?;
            return Ok(Outcome::Negative);
        }
        Err(error) => return Err(anyhow::Error::new(error).context(path)),
    };
    let (text, value) = (linear_text(&found), json(&linear_json(&found))?);
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("linear.txt"), &text)?;
        write(&dir.join("linear.json"), &value)?;
        for file in linear_files(&found.system) {
            write(&dir.join(file.name), &file.text)?;
        }
    }
    print(if output.json { &value } else { &text })?;
    if let (Some(dir), false) = (&output.out, output.json) {
        line(&format!("written to {}: linear.txt, linear.json, linear.py, linear.m, linear.jl", dir.display()))?;
    }
    Ok(Outcome::Done)
}
