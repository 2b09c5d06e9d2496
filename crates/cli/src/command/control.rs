//! `bracketry control`: the closed loop of a problem file.

use std::path::{Path, PathBuf};

use bracketry::mpc::{ControlError, ControlProblem, Controlled, MpcError, control_watched};
use bracketry::report::control as printed;
use clap::Args;

use super::output::{csv, figure, folder, json, line, print, spinner, write};
use super::style::warning;
use super::{Outcome, OutputArgs};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 2] = [
    ("Swing a pendulum up, with trajectory and plots", "bracketry control models/cart_pole_swing_up.toml --out out"),
    ("Other noise", "bracketry control problem.toml --seed 7"),
];

/// Arguments of `control`.
#[derive(Args)]
pub(crate) struct ControlArgs {
    /// Problem file (TOML): model, horizon, cost, bounds; docs/mpc.md documents every key
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) problem: PathBuf,
    /// Seed of the measurement noise; overrides `seed` in [run]
    #[arg(long, allow_negative_numbers = true, value_name = "N")]
    seed: Option<u64>,
}

/// Runs the loop and writes what it gave.
pub(crate) fn run(args: &ControlArgs, output: &OutputArgs) -> anyhow::Result<Outcome> {
    let progress = spinner("reading and building the problem");
    let mut problem = ControlProblem::read(&args.problem)?;
    if let Some(seed) = args.seed {
        problem.conditions.seed = seed;
    }
    progress.set_message("first plan");
    let total = problem.samples;
    let outcome = control_watched(&problem, |k| progress.set_message(format!("closed loop, sample {k} of {total}")));
    progress.finish_and_clear();
    let controlled = match outcome {
        // The loop ran until its plant ended: an answer, though a negative one.
        Err(stop @ ControlError::Mpc(MpcError::Plant { .. })) => {
            warning(&printed::error(&problem, &stop));
            return Ok(Outcome::Negative);
        }
        other => other?,
    };
    let report = &controlled.run.report;
    let mut drawn = false;
    if let Some(dir) = &output.out {
        folder(dir)?;
        write(&dir.join("control.json"), &json(report)?)?;
        drawn = write_files(dir, &problem, &controlled)?;
    }
    if output.json {
        print(&json(report)?)?;
    } else {
        print(&printed::text(report))?;
        match &output.out {
            Some(dir) => {
                let figure = if drawn { ", closed_loop.svg, closed_loop.png" } else { "" };
                line(&format!("written to {}: control.json, closed_loop.csv{figure}", dir.display()))?;
            }
            None => line("(--out DIR writes trajectory and plots)")?,
        }
    }
    Ok(if report.succeeded { Outcome::Done } else { Outcome::Negative })
}

/// The table and the figure; says whether there is a figure.
fn write_files(dir: &Path, problem: &ControlProblem, controlled: &Controlled) -> anyhow::Result<bool> {
    let (header, rows) = printed::table(problem, controlled);
    csv(&dir.join("closed_loop.csv"), &header, rows.iter().map(Vec::as_slice))?;

    Ok(figure(printed::figure(problem, controlled), &dir.join("closed_loop")))
}
