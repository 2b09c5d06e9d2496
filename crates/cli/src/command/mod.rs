//! Subcommands: arguments in, report out, exit code by outcome.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};

mod affinize;
mod analyze;
mod certify;
mod control;
mod demo;
mod diagnose;
mod ending;
mod experiment;
mod export;
mod file_kind;
mod from_rest;
mod help;
mod interrupt;
mod limits;
mod live;
mod new;
mod operating_point;
mod output;
mod own_folder;
mod plate;
mod progress;
mod publication;
mod reproduce;
mod seed;
mod shell;
mod simulate;
mod steer;
mod stiffness;
pub(crate) mod style;
mod transform;

use file_kind::{FileKind, Given};
use help::{EXIT_CODES, UNITS, WRITTEN, examples, guide};
use limits::{Limits, TimeLimit};
pub(crate) use output::{CommonArgs, Outcome};
use stiffness::StiffnessCommand;

/// What can my inputs reach, how do I get there, and where are the equations wrong?
#[derive(Parser)]
#[command(
    name = "bracketry", version, about, max_term_width = 100, styles = help::STYLES,
    after_long_help = guide(&FIRST_STEPS, &[EXIT_CODES, UNITS, (
        "Color",
        "On terminals only; NO_COLOR=1 turns it off, and CLICOLOR_FORCE=1 turns it on.",
    )]),
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    output: CommonArgs,
}

const FIRST_STEPS: [(&str, &str); 6] = [
    ("Run the complete example, a vibrating plate", "bracketry demo"),
    ("Start your own model", "bracketry new mass"),
    ("Find what its inputs reach", "bracketry analyze mass.toml"),
    ("Simulate it", "bracketry simulate mass.toml --scenario mass_scenario.toml --out out"),
    ("Close the loop", "bracketry control mass_problem.toml --out out"),
    ("Diagnose it from measured data", "bracketry diagnose mass.toml run.csv --hold linear --out out"),
];

/// What the time limit ends in the search for an operating point.
const NO_MORE_STARTS: &str = "Stop after this many seconds; no further searches are started";

/// In the order in which they are used, which is that of the help.
#[derive(Subcommand)]
enum Command {
    /// Complete example: the vibrating plate, from its published equations to a controller on the plant
    #[command(after_help = examples(&demo::EXAMPLES), after_long_help = guide(&demo::EXAMPLES, &[
        ("What it does",
            "Analyzes the published model of a plate that moves an object without grasping it. Closes the loop twice with \
             this model: on its own equations, and on a plant with contact over the whole footprint (a simulation). Diagnoses \
             the logs, and controls the plant with the extended model. Takes about 40 s on two cores. Results are written \
             to out/demo, or to --out, at the end of each chapter. The folder must be empty, new, or written by an earlier demo."),
        ("Exit codes", "0  the extended model reaches the target, and the published one does not\n\
             1  any other outcome; see the report\n2  bad input"),
    ]))]
    Demo(demo::DemoArgs),
    /// Write a commented model with a scenario and a problem
    #[command(after_help = examples(&new::EXAMPLES), after_long_help = guide(&new::EXAMPLES, &[WRITTEN]))]
    New(new::NewArgs),
    /// Affine form, ranks, brackets, local controllability, flatness, and observability
    #[command(after_help = examples(&analyze::EXAMPLES), after_long_help = guide(&analyze::EXAMPLES, &[(
        "Exit codes",
        "0  decided: every generic dimension, the requests of --at, --bracket, and --determines, and which states \
         and parameters the outputs determine; with --parameters or --map, the list of cases is proven \
         complete; with --identifiability, local and global identifiability of all parameters are known; with --from-rest, the answer is yes or no\n\
         1  one of these is undecided, or no affine form was found; the report says which and why (other quantities may be unknown)\n2  bad input",
    )]))]
    Analyze(analyze::AnalyzeArgs),
    /// Write the model in a form that is affine in its inputs
    #[command(after_help = examples(&affinize::EXAMPLES), after_long_help = guide(&affinize::EXAMPLES, &[(
        "Exit codes", "0  written\n1  no affine form was found; the message gives the reason\n2  bad input",
    )]), mut_arg("limit", |a| a.help("After this many seconds, expressions may not be simplified")))]
    Affinize(affinize::AffinizeArgs),
    /// Find an equilibrium or operating point, with fixed and free variables
    #[command(after_help = examples(&operating_point::TRIM_EXAMPLES), after_long_help = guide(&operating_point::TRIM_EXAMPLES, &[(
        "Exit codes", "0  found, with inputs within their ranges\n1  not found, or found only with inputs outside their ranges; the report gives the best point\n2  bad input",
    )]), mut_arg("limit", |a| a.help(NO_MORE_STARTS)))]
    Trim(operating_point::TrimArgs),
    /// Linear system around a point: A, B, C, D, poles, zeros, distances to uncontrollability and unobservability, and gains
    #[command(after_help = examples(&operating_point::LINEARIZE_EXAMPLES), after_long_help = guide(&operating_point::LINEARIZE_EXAMPLES, &[(
        "Exit codes", "0  linearized\n1  the equations are not smooth at the point, or no operating point was found\n2  bad input",
    )]), mut_arg("limit", |a| a.help(NO_MORE_STARTS)))]
    Linearize(operating_point::LinearizeArgs),
    /// Lyapunov functions, regions of attraction, storage functions, and conserved quantities, proved in exact arithmetic
    #[command(after_help = examples(&certify::EXAMPLES), after_long_help = guide(&certify::EXAMPLES, &[(
        "Exit codes", "0  everything requested is proved\n1  something is not proved; the report says why\n2  bad input",
    )]))]
    Certify(certify::CertifyArgs),
    /// Transform the model to a normal form or decomposition, with the change of coordinates and its inverse
    #[command(after_help = examples(&transform::EXAMPLES), after_long_help = guide(&transform::EXAMPLES, &[(
        "Exit codes", "0  found, and confirmed by transforming back\n1  no such form exists, or none was found; the report gives the reason\n2  bad input",
    ), (
        "Files", "--out DIR writes the report, the transformed model, and its parts; --out FILE.toml writes the transformed model only",
    )]))]
    Transform(transform::TransformArgs),
    /// Write the equations with their Jacobians as source code: C, Rust, Python, CasADi, Julia
    #[command(after_help = examples(&export::EXAMPLES), after_long_help = guide(&export::EXAMPLES, &[WRITTEN]))]
    Export(export::ExportArgs),
    /// Find inputs that move a model from one state to another
    #[command(after_help = examples(&steer::EXAMPLES), after_long_help = guide(&steer::EXAMPLES, &[
        ("Exit codes", "0  the simulated motion ends within 1e-6 of the target in every state, with inputs within their ranges\n\
         1  only a first guess, or nothing, was found; the report gives the reason\n2  bad input"),
        UNITS,
    ]), mut_arg("limit", |a| a.help("Try no further plans after this many seconds")))]
    Steer(steer::SteerArgs),
    /// Integrate a model with exact stick–slip friction
    #[command(after_help = examples(&simulate::EXAMPLES), after_long_help = guide(&simulate::EXAMPLES, &[
        ("Exit codes", "0  simulated to the end\n1  stopped early (blow-up, chattering); the report says when\n2  bad input"),
        UNITS,
    ]))]
    Simulate(simulate::SimulateArgs),
    /// Run the closed loop of a problem file
    #[command(after_help = examples(&control::EXAMPLES), after_long_help = guide(&control::EXAMPLES, &[
        ("Exit codes", "0  the run succeeded\n1  a target was missed, a sample had no solution, a note reports a failure, or the plant stopped\n2  bad input"),
        UNITS,
    ]))]
    Control(control::ControlArgs),
    /// Find what a model lacks from measured data: causes, extended model, improvement
    #[command(after_help = examples(&diagnose::EXAMPLES), after_long_help = guide(&diagnose::EXAMPLES, &[
        ("Exit codes",
            "0  a cause is found, named or as an unknown term, or nothing is wrong\n\
             1  a column is wrong, the error is explained only in part or not at all, the data are uninformative, or the time limit was reached\n2  bad input"),
        UNITS,
    ]))]
    Diagnose(Box<diagnose::DiagnoseArgs>),
    /// Find inputs within limits that tell two models apart, or that identify parameters best
    #[command(after_help = examples(&experiment::EXAMPLES), after_long_help = guide(&experiment::EXAMPLES, &[
        ("Exit codes",
            "0  the explanations are told apart, or all parameters are identified, on exact simulations\n\
             1  they are not; the report says what would help\n2  bad input"),
        UNITS,
    ]), mut_arg("limit", |a| a.help("End after about this many seconds; after six tenths of them, no further optimization is started")))]
    Experiment(Box<experiment::ExperimentArgs>),
    /// Run an experiment on the vibrating plate with a chosen model, and optionally compare it with a log
    #[command(after_help = examples(&plate::EXAMPLES), after_long_help = guide(&plate::EXAMPLES, &[
        ("Exit codes",
            "0  the target is reached\n\
             1  it is not reached, the run ended early, or the comparison with a log is undecided; if noise \
             leaves a sign of the amplitude undecided, only the comparison before that time counts\n2  bad input; the message gives the location and the \
             remedy"),
        ("Units", "SI and radians; ω in units of π"),
    ]))]
    Plate(Box<plate::PlateArgs>),
    /// The publication behind the plate and the robots: each equation, where it is here, and whether it is right
    #[command(after_help = examples(&publication::EXAMPLES), after_long_help = guide(&publication::EXAMPLES, &[(
        "Exit codes", "0  printed\n2  there is no such number",
    )]))]
    Publication(publication::PublicationArgs),
    /// Published results that are reproduced here: claim, command, our figure, and verdict, by name, author, or year
    #[command(after_help = examples(&reproduce::EXAMPLES), after_long_help = guide(&reproduce::EXAMPLES, &[(
        "Exit codes", "0  printed\n2  there is no such result",
    )]))]
    Reproduce(reproduce::ReproduceArgs),
    /// Stiffness of a robot: identify it from measurements and compensate for the deformation
    #[command(subcommand, after_help = examples(&stiffness::EXAMPLES))]
    Stiffness(StiffnessCommand),
    /// Print a shell completion script
    #[command(after_help = examples(&shell::COMPLETION_EXAMPLES))]
    Completions(shell::CompletionsArgs),
    /// Manual pages: print one, or write all of them into a folder with --out
    #[command(after_help = examples(&shell::MAN_EXAMPLES))]
    Man(shell::ManArgs),
}

impl Command {
    /// The time limit of a command that has one.
    fn time_limit(&self) -> Option<TimeLimit> {
        match self {
            Self::Analyze(args) => Some(args.time_limit),
            Self::Affinize(args) => Some(args.time_limit),
            Self::Trim(args) => Some(args.time_limit),
            Self::Linearize(args) => Some(args.time_limit),
            Self::Certify(args) => Some(args.time_limit),
            Self::Transform(args) => Some(args.time_limit),
            Self::Steer(args) => Some(args.time_limit),
            Self::Diagnose(args) => Some(TimeLimit::of(args.time_limit)),
            Self::Experiment(args) => Some(args.time_limit),
            _ => None,
        }
    }

    /// The files that are read, with what they are to be.
    fn files(&self) -> Vec<Given> {
        match self {
            Self::Analyze(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Affinize(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Trim(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Transform(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Export(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Linearize(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Certify(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Steer(args) => vec![Given::new(&args.model, FileKind::Model)],
            Self::Simulate(args) => args.files(),
            Self::Diagnose(args) => args.files(),
            Self::Experiment(args) => args.files(),
            Self::Plate(args) => args.files(),
            Self::Stiffness(command) => command.files(),
            Self::Control(args) => Given::problem(&args.problem),
            Self::Demo(_)
            | Self::New(_)
            | Self::Publication(_)
            | Self::Reproduce(_)
            | Self::Completions(_)
            | Self::Man(_) => Vec::new(),
        }
    }
}

/// Reads the command line.
///
/// # Errors
/// What is wrong with it, and help where that was asked for.
pub(crate) fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Cli, clap::Error> {
    Cli::try_parse_from(arguments).map_err(|mut e| {
        // A file where the command belongs.
        if e.kind() == ErrorKind::InvalidSubcommand
            && let Some(ContextValue::String(word)) = e.get(ContextKind::InvalidSubcommand)
            && let Some(command) = FileKind::command_for(std::path::Path::new(word))
        {
            e.insert(
                ContextKind::Suggested,
                ContextValue::StyledStrs(vec![format!("for this file: `{command}`").into()]),
            );
        }
        e
    })
}

/// Runs what the command line asks for.
///
/// # Errors
/// Bad input: a file or an option, with place and remedy.
pub(crate) fn run(cli: Cli) -> anyhow::Result<Outcome> {
    let mut output = cli.output;
    output.limits = Limits::watch(output.memory_limit, cli.command.as_ref().and_then(Command::time_limit));
    let files = cli.command.as_ref().map(Command::files).unwrap_or_default();
    let result = match cli.command {
        None => {
            Cli::command().print_long_help()?;
            Ok(Outcome::Done)
        }
        Some(Command::Demo(args)) => demo::run(&args, &output),
        Some(Command::Analyze(args)) => analyze::analyze(&args, &output),
        Some(Command::Affinize(args)) => affinize::affinize(&args, &output),
        Some(Command::Trim(args)) => operating_point::trim(&args, &output),
        Some(Command::Linearize(args)) => operating_point::linearize(&args, &output),
        Some(Command::Certify(args)) => certify::run(&args, &output),
        Some(Command::Transform(args)) => transform::transform(&args, &output),
        Some(Command::Export(args)) => export::run(&args, &output),
        Some(Command::Steer(args)) => steer::run(&args, &output),
        Some(Command::Simulate(args)) => simulate::run(&args, &output),
        Some(Command::Plate(args)) => plate::run(&args, &output),
        Some(Command::Publication(args)) => publication::run(&args, &output),
        Some(Command::Reproduce(args)) => reproduce::run(&args, &output),
        Some(Command::Diagnose(args)) => diagnose::run(&args, &output),
        Some(Command::Experiment(args)) => experiment::run(&args, &output),
        Some(Command::Stiffness(command)) => stiffness::run(&command, &output),
        Some(Command::Control(args)) => control::run(&args, &output),
        Some(Command::New(args)) => new::run(&args, &output),
        Some(Command::Completions(args)) => shell::completions(&args, &mut Cli::command(), &output),
        Some(Command::Man(args)) => shell::man(&args, Cli::command(), &output),
    };
    // A file of another kind explains more than the first thing in it that does not belong there.
    result.map_err(|e| file_kind::mistaken(&files).map_or(e, anyhow::Error::msg))
}
