//! Subcommands: arguments in, report out, exit code by outcome.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

mod affinize;
mod analyze;
mod control;
mod diagnose;
mod main_job;
mod output;
mod plate;
mod simulate;
mod stiffness;

/// How a command ended; bad input is an error instead.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Outcome {
    /// Exit code 0.
    Done,
    /// Ran, but the answer is negative or was not reached: exit code 1.
    Negative,
}

/// What can my inputs reach, how do I get there, and where are the equations wrong?
///
/// Without a command: the main job on the vibrating plate, from its equations to a closed loop that moves
/// position and orientation at the same time; results go to `out/`.
#[derive(Parser)]
#[command(version, about, max_term_width = 100)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    output: OutputArgs,
}

/// Where results go.
#[derive(Args, Clone)]
pub(crate) struct OutputArgs {
    /// Print one JSON object instead of the human report
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Folder for files and plots
    #[arg(long, global = true, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

#[derive(Subcommand)]
enum Command {
    /// Affine form, modes, ranks, brackets, and what no input influences
    #[command(after_help = "Examples:\n  bracketry analyze models/plate_published.toml\n  \
        bracketry analyze models/cart_pole.toml --at th=pi --markdown")]
    Analyze(analyze::AnalyzeArgs),
    /// Write the model in a form that is affine in its inputs
    #[command(after_help = "Example:\n  bracketry affinize models/plate_published.toml > plate_affine.toml")]
    Affinize(affinize::AffinizeArgs),
    /// Integrate a model with exact stick–slip friction
    #[command(
        after_help = "Example:\n  bracketry simulate models/plate_published.toml --scenario models/plate_experiment_2.toml --out out"
    )]
    Simulate(simulate::SimulateArgs),
    /// Run an experiment on the vibrating plate, on the model of your choice, beside a log if there is one
    #[command(after_help = "Examples:\n  bracketry plate 1 --shape ellipse:0.15x0.10 --out out --gif\n  \
        bracketry plate 2 --omega 4 --model published\n  \
        bracketry plate 1 --compare log.csv --motion log --mu 0.3 --out out")]
    Plate(Box<plate::PlateArgs>),
    /// From measured data to what the model gets wrong: the cause, the extended model, the gain
    #[command(
        after_help = "Examples:\n  bracketry diagnose models/emps.toml run.csv --validate second.csv --out out\n  \
        bracketry diagnose slider.toml log.csv --rename force=u --fix g --json"
    )]
    Diagnose(Box<diagnose::DiagnoseArgs>),
    /// Stiffness of a robot: identify it from measurements, compensate the deformation
    #[command(subcommand)]
    Stiffness(stiffness::StiffnessCommand),
    /// Close the loop of a problem file
    #[command(after_help = "Example:\n  bracketry control models/cart_pole_swing_up.toml --out out")]
    Control {
        /// Problem file
        problem: PathBuf,
        /// Seed of the measurement noise, in place of `seed` in [run]
        #[arg(long)]
        seed: Option<u64>,
    },
}

/// Runs what the command line asks for.
///
/// # Errors
/// Bad input: a file or an option, with place and remedy.
pub(crate) fn run(cli: Cli) -> anyhow::Result<Outcome> {
    let output = cli.output;
    match cli.command {
        None => main_job::run(&output),
        Some(Command::Analyze(args)) => analyze::analyze(&args, &output),
        Some(Command::Affinize(args)) => affinize::affinize(&args, &output),
        Some(Command::Simulate(args)) => simulate::run(&args, &output),
        Some(Command::Plate(args)) => plate::run(&args, &output),
        Some(Command::Diagnose(args)) => diagnose::run(&args, &output),
        Some(Command::Stiffness(command)) => stiffness::run(&command, &output),
        Some(Command::Control { problem, seed }) => control::run(&problem, seed, &output),
    }
}
