//! `bracketry steer`: an input that moves a model from one state to another.

use std::path::{Path, PathBuf};

use anyhow::Context;
use bracketry::report::steering::{
    steering_figure, steering_inputs, steering_json, steering_path, steering_scenario, steering_text,
    steering_trajectory,
};
use bracketry::steer::from_rest::Bound;
use bracketry::steer::{SteerMethod, SteerOptions, SteerStatus, Steering, own_inputs, steer};
use clap::{Args, ValueEnum};

use super::limits::TimeLimit;
use super::output::{csv, figure, folder, json, line, print, write};
use super::progress::spinner;
use super::seed::seed;
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("Move a unicycle sideways", "bracketry steer models/unicycle.toml --from x=0,y=0 --to x=0,y=1 --out out"),
    ("Replay the motion", "bracketry simulate models/unicycle.toml --scenario out/scenario.toml"),
    ("With piecewise constant inputs", "bracketry steer models/rolling_disk.toml --to phi=1 --method nilpotent"),
];

/// The method, or the first that reaches the end.
#[derive(Clone, Copy, ValueEnum)]
enum MethodArg {
    /// The first of the other methods that reaches the end
    Auto,
    /// Sinusoids in the chained form: two inputs, no drift
    Chained,
    /// Piecewise constant inputs from Philip Hall coordinates: no drift
    Nilpotent,
    /// Polynomials in flat outputs
    Flat,
    /// Loops of the inputs from rest to rest under dry friction, within --bounds
    Loops,
    /// Sinusoids found by iterations on the end error
    Shooting,
}

/// Arguments of `steer`.
#[derive(Args)]
pub(crate) struct SteerArgs {
    /// Model file (TOML)
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) model: PathBuf,
    /// Initial state, such as x=0,th=pi/2; unnamed states are 0 [default: the model's point]
    #[arg(long, value_name = "NAME=VALUE,…")]
    from: Option<String>,
    /// State at the end; unnamed states are 0
    #[arg(long, value_name = "NAME=VALUE,…")]
    to: String,
    /// Duration of the motion [default: long enough for the ranges of the inputs]
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Bounds of inputs and of their derivatives for --method loops, such as "der(X,2)=-4..4,theta=-0.2..0.2"
    #[arg(long, value_name = "NAME=LOW..HIGH,…", allow_hyphen_values = true)]
    bounds: Option<String>,
    /// How the inputs are found
    #[arg(long, value_enum, default_value = "auto")]
    method: MethodArg,
    #[command(flatten)]
    pub(crate) time_limit: TimeLimit,
    /// Seed of random waypoints and initial guesses
    #[arg(long, allow_negative_numbers = true, value_name = "N", default_value_t = 1, value_parser = seed)]
    seed: u64,
}

/// Finds the inputs, prints the report, and writes the files.
pub(crate) fn run(args: &SteerArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    let path = args.model.display().to_string();
    let given = output.limits.read(&args.model)?;
    let mut system = own_inputs(&given).with_context(|| path.clone())?;
    let method = match args.method {
        MethodArg::Auto => None,
        MethodArg::Chained => Some(SteerMethod::Chained),
        MethodArg::Nilpotent => Some(SteerMethod::Nilpotent),
        MethodArg::Flat => Some(SteerMethod::Flat),
        MethodArg::Loops => Some(SteerMethod::Loops),
        MethodArg::Shooting => Some(SteerMethod::Shooting),
    };
    let options = SteerOptions {
        duration: args.duration,
        bounds: args.bounds.as_deref().map_or(Ok(Vec::new()), Bound::list).context("--bounds")?,
        method,
        time_limit: Some(args.time_limit.get()),
        seed: args.seed,
        stop: system.pool.stop_flag().clone(),
        ..SteerOptions::named(&mut system, args.from.as_deref(), &args.to)?
    };
    let progress = spinner("steering");
    let found = steer(&given, &options).with_context(|| path.clone())?;
    progress.finish_and_clear();
    let text = steering_text(&found);
    let mut written = Vec::new();
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("steering.txt"), &text)?;
        write(&dir.join("steering.json"), &json(&steering_json(&found))?)?;
        written = write_motion(dir, &found)?;
        if !given.input_derivatives.is_empty() {
            write(&dir.join("model.toml"), &found.system.to_toml()?)?;
            written.push("model.toml (with integrators in front of the inputs)");
        }
    }
    print(&if output.json { json(&steering_json(&found))? } else { text })?;
    if let (Some(dir), false) = (&output.out, output.json) {
        let list: Vec<&str> = ["steering.txt", "steering.json"].into_iter().chain(written).collect();
        line(&format!("written to {}: {}", dir.display(), list.join(", ")))?;
    }
    Ok(if found.status == SteerStatus::Reached { Outcome::Done } else { Outcome::Negative })
}

/// Tables, scenario, and figures of a motion, and what they are called.
fn write_motion(dir: &Path, found: &Steering) -> anyhow::Result<Vec<&'static str>> {
    let mut written = Vec::new();
    if let Some((header, rows)) = steering_inputs(found) {
        csv(&dir.join("inputs.csv"), &header, rows.iter().map(Vec::as_slice))?;
        written.push("inputs.csv");
    }
    if let Some(text) = steering_scenario(found, "inputs.csv") {
        write(&dir.join("scenario.toml"), &text)?;
        written.push("scenario.toml");
    }
    if let Some((header, rows)) = steering_trajectory(found) {
        csv(&dir.join("trajectory.csv"), &header, rows.iter().map(Vec::as_slice))?;
        written.push("trajectory.csv");
    }
    if steering_figure(found).is_some_and(|drawing| figure(&drawing, &dir.join("steering"))) {
        written.push("steering.svg, steering.png");
    }
    if steering_path(found).is_some_and(|drawing| figure(&drawing, &dir.join("path"))) {
        written.push("path.svg, path.png");
    }
    Ok(written)
}
