//! `bracketry control`: the closed loop of a problem file.

use std::path::{Path, PathBuf};
use std::time::Duration;

use bracketry::mpc::{ControlError, ControlProblem, Controlled, LiveController, MpcError, control_watched};
use bracketry::report::Figure;
use bracketry::report::control as printed;
use clap::Args;

use super::live::{Limits, serve, wait_until_closed};
use super::output::{PageArgs, csv, folder, json, line, listed, print, save_figures, write};
use super::progress::spinner;
use super::seed::seed;
use super::style::warning;
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("Swing a pendulum up, with trajectory and plots", "bracketry control models/cart_pole_swing_up.toml --out out"),
    ("Other noise", "bracketry control problem.toml --seed 7"),
    ("Control a plant of your own over a pipe", "bracketry control problem.toml --live --deadline 0.05"),
];

/// The page with everything.
const PAGE: &str = "control.html";

/// Arguments of `control`.
#[derive(Args)]
pub(crate) struct ControlArgs {
    /// Problem file (TOML): model, horizon, cost, bounds; docs/mpc.md in the repository documents every key
    #[arg(value_hint = clap::ValueHint::FilePath)]
    pub(crate) problem: PathBuf,
    #[command(flatten)]
    page: PageArgs,
    /// Seed of the measurement noise; overrides `seed` in [run]
    #[arg(long, allow_negative_numbers = true, value_name = "N", value_parser = seed)]
    seed: Option<u64>,
    /// Control a plant of your own: read measurements from standard input and write inputs to standard output, one JSON object
    /// per line; see docs/live.md in the repository
    #[arg(long, conflicts_with = "open")]
    live: bool,
    /// With --live: maximum time from an input to the next measurement, s; then the failure policy applies
    #[arg(long, requires = "live", value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    deadline: Option<Duration>,
    /// With --live: maximum time without any message, s; then the session ends with exit code 1
    #[arg(long, requires = "live", value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds, default_value = "60")]
    timeout: Duration,
    /// With --live: send a heartbeat at this interval, s
    #[arg(long, requires = "live", value_name = "SECONDS", allow_negative_numbers = true, value_parser = seconds)]
    heartbeat: Option<Duration>,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let number: f64 = text.parse().map_err(|_| "write a number of seconds".to_owned())?;
    Duration::try_from_secs_f64(number)
        .ok()
        .filter(|d| !d.is_zero() && *d < Duration::from_secs(1_000_000))
        .ok_or_else(|| "write a positive number of seconds below a million".to_owned())
}

/// Runs the loop and writes what it gave.
pub(crate) fn run(args: &ControlArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    args.page.check(output)?;
    let progress = spinner("reading and building the problem");
    let mut problem = ControlProblem::read(&args.problem)?;
    if let Some(seed) = args.seed {
        problem.conditions.seed = seed;
    }
    progress.set_message("first plan");
    let mut problem = problem.with_free_values()?.into_owned();
    if args.live {
        let controller = problem.controller()?;
        progress.finish_and_clear();
        return control_live(controller, args, output);
    }
    problem.conditions.keep_predictions = output.out.is_some();
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
        let mut files = listed(&[("control.json", "all results, for programs")]);
        files.extend(write_tables(dir, &problem, &controlled)?);
        let caption = "States, inputs, and named constraints over time, with targets, references, and bounds";
        let figures = [Figure::new("closed_loop", caption, printed::figure(&problem, &controlled))];
        let saved = save_figures(&figures, dir);
        drawn = !saved.is_empty();
        files.extend(saved);
        let page = dir.join(PAGE);
        write(&page, &printed::page(&problem, report, &figures, &files))?;
        args.page.open(&page);
    }
    if output.json {
        print(&json(report)?)?;
    } else {
        print(&printed::text(report))?;
        match &output.out {
            Some(dir) => {
                let plan = if controlled.run.plan.is_some() { ", plan.csv" } else { "" };
                let figure = if drawn { ", closed_loop.svg, closed_loop.png" } else { "" };
                line(&format!(
                    "written to {}: {PAGE}, control.json, closed_loop.csv, predictions.csv{plan}{figure}",
                    dir.display()
                ))?;
            }
            None => line("(--out DIR writes a page with plots, and the trajectory as tables)")?,
        }
    }
    Ok(if report.succeeded { Outcome::Done } else { Outcome::Negative })
}

/// Samples that `--live --out DIR` keeps: the last.
const KEPT: usize = 1_000_000;

/// Answers the measurements of a peer on standard input and output.
fn control_live(mut controller: LiveController, args: &ControlArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    if let Some(dir) = &output.out {
        folder(dir)?;
        controller.keep_log(KEPT);
    }
    let period_ms = 1e3 * controller.period_seconds();
    let limits = Limits { deadline: args.deadline, timeout: args.timeout, heartbeat: args.heartbeat };
    let ended = serve(controller, std::io::stdin(), std::io::stdout(), wait_until_closed, limits)?;
    if let (Some(dir), Some(log)) = (&output.out, &ended.log) {
        csv(&dir.join("closed_loop.csv"), log.names(), log.rows())?;
    }
    if !ended.succeeded() {
        warning(&ended.to_string());
    }
    if let Some(late) = printed::late(&ended.late, period_ms) {
        warning(&late);
    }
    Ok(if ended.succeeded() { Outcome::Done } else { Outcome::Negative })
}

/// Writes the tables, and says what is in them.
fn write_tables(
    dir: &Path,
    problem: &ControlProblem,
    controlled: &Controlled,
) -> anyhow::Result<Vec<(String, String)>> {
    let mut files = listed(&[
        ("closed_loop.csv", "the closed loop over time"),
        ("predictions.csv", "the prediction of every sample"),
    ]);
    let (header, rows) = printed::table(problem, controlled);
    csv(&dir.join("closed_loop.csv"), &header, rows.iter().map(Vec::as_slice))?;
    let (header, rows) = printed::predictions(problem, controlled);
    csv(&dir.join("predictions.csv"), &header, rows.iter().map(Vec::as_slice))?;
    if let Some((header, rows)) = printed::plan(problem, controlled) {
        csv(&dir.join("plan.csv"), &header, rows.iter().map(Vec::as_slice))?;
        files.extend(listed(&[("plan.csv", "the plan over time")]));
    }
    Ok(files)
}
