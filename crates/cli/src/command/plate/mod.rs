//! `bracketry plate`: one experiment on the vibrating plate, on one model, perhaps beside a log.

mod files;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use bracketry::plate::run::{Comparison, GivenOption, NumberOption, PlateOptions, PlateOutcome, TextOption};
use bracketry::plate::{PlateExperiment, PlateLog};
use bracketry::report::plate;
use clap::{Args, ValueEnum};

use super::file_kind::{FileKind, Given};
use super::output::{PageArgs, folder, json, line, print};
use super::progress::spinner;
use super::{CommonArgs, Outcome};

/// Shown by the help.
pub(crate) const EXAMPLES: [(&str, &str); 3] = [
    ("Experiment 1 with an ellipse, with an animation", "bracketry plate 1 --shape ellipse:0.15x0.10 --out out --gif"),
    ("Another frequency, on the published model", "bracketry plate 2 --omega 4 --model published"),
    (
        "Compare with a log and use its plate motion",
        "bracketry plate 1 --compare log.csv --motion log --mu 0.3 --out out",
    ),
];

/// What moves the plate.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum MotionArg {
    /// The experiment's formula
    Formula,
    /// The columns plate_X and plate_theta of the log
    Log,
}

/// Arguments of `plate`. Texts and numbers are checked with those of scenario files.
#[derive(Args)]
pub(crate) struct PlateArgs {
    /// Experiment 1 (orientation), 2 (along x), or 3 (along y), or a scenario file (TOML) with the options below by name
    what: Option<String>,
    /// Experiment 1, 2, or 3
    #[arg(long, conflicts_with = "what", value_name = "N")]
    experiment: Option<String>,
    /// Frequency ω of experiment 2 in units of π [default: 3]
    #[arg(long, allow_negative_numbers = true)]
    omega: Option<f64>,
    /// Model of the contact: published, point, reduced, area, or body [default: area]
    #[arg(long)]
    model: Option<String>,
    /// disk:R, ellipse:AxB (semi-axes), rectangle:AxB (full side lengths), or polygon:FILE.csv (rows x,y); meters
    /// [default: disk:0.12]
    #[arg(long)]
    shape: Option<String>,
    /// Thickness of the object in meters [default: 0.005]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    thickness: Option<f64>,
    /// Mass of the object in kg [default: 0.2]
    #[arg(long, value_name = "KG", allow_negative_numbers = true)]
    mass: Option<f64>,
    /// Where the object presses on the plate: footprint, scaled:F (the footprint scaled about its center), ring:S (the rim
    /// scaled), feet:x,y;x,y;…, or map:FILE.csv (rows x,y,weight); meters from the center of the shape; model area only
    /// [default: footprint]
    #[arg(long)]
    bearing: Option<String>,
    /// Center of mass from the center of the shape in meters; model area only [default: 0,0]
    #[arg(long, allow_hyphen_values = true, value_name = "X,Y")]
    center_of_mass: Option<String>,
    /// Friction coefficient of sliding [default: 0.3]
    #[arg(long, allow_negative_numbers = true)]
    mu: Option<f64>,
    /// Friction law: coulomb, static:MU_S, stribeck:MU_S,V, anisotropic:MU_Y, or viscous:C; --mu sets the sliding friction
    /// [default: coulomb]
    #[arg(long)]
    friction: Option<String>,
    /// Start at rest: x,y,phi in meters and radians, or degrees such as 45deg [default: that of log or experiment]
    #[arg(long, allow_hyphen_values = true, value_name = "X,Y,PHI")]
    start: Option<String>,
    /// Duration in seconds [default: that of the log, else 15]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    seconds: Option<f64>,
    /// Contact points of the area model [default: 48]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    points: Option<f64>,
    /// Time step of the models area and body in seconds [default: 5e-4]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dt: Option<f64>,
    /// Restitution of impacts of the body model, 0 to 1 [default: 0]
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    restitution: Option<f64>,
    /// What happens when the amplitude changes: world (the plate jumps, the object stays fixed in the inertial frame) or smooth [default: world]
    #[arg(long)]
    jumps: Option<String>,
    /// Interval between the rows of the result in seconds [default: 0.002]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    sample: Option<f64>,
    /// Compare with a log: CSV with columns t, x_plate, y_plate, phi_plate (SI, radians)
    #[arg(long, value_name = "LOG.csv")]
    compare: Option<PathBuf>,
    /// Standard deviation of the noise of the log in the coordinate that the experiment moves, in meters or radians
    /// [default: estimated from the log]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    noise: Option<f64>,
    /// What moves the plate
    #[arg(long, value_enum, default_value = "formula")]
    motion: MotionArg,
    #[command(flatten)]
    page: PageArgs,
    /// Also write plate.gif: an animation in real time
    #[arg(long)]
    gif: bool,
}

impl PlateArgs {
    pub(crate) fn files(&self) -> Vec<Given> {
        let scenario = self.what.as_deref().map(Path::new).filter(|path| is_file(path));
        let scenario = scenario.map(|path| Given::new(path, FileKind::PlateScenario));
        scenario.into_iter().chain(self.compare.iter().map(|path| Given::new(path, FileKind::Table))).collect()
    }

    fn scenario(&self) -> anyhow::Result<PlateOptions> {
        Ok(match self.what.as_deref().map(Path::new).filter(|what| is_file(what)) {
            Some(path) => PlateOptions::read(path)?,
            None => PlateOptions::default(),
        })
    }

    /// The options that are given, numbers before texts.
    fn options(&self) -> anyhow::Result<PlateOptions> {
        let number = self.what.as_ref().filter(|what| !is_file(Path::new(what)));
        let numbers = [
            (NumberOption::Omega, self.omega),
            (NumberOption::Thickness, self.thickness),
            (NumberOption::Mass, self.mass),
            (NumberOption::Mu, self.mu),
            (NumberOption::Seconds, self.seconds),
            (NumberOption::Points, self.points),
            (NumberOption::Dt, self.dt),
            (NumberOption::Restitution, self.restitution),
            (NumberOption::Sample, self.sample),
            (NumberOption::Noise, self.noise),
        ];
        let texts = [
            (TextOption::Experiment, number.or(self.experiment.as_ref())),
            (TextOption::Model, self.model.as_ref()),
            (TextOption::Shape, self.shape.as_ref()),
            (TextOption::Start, self.start.as_ref()),
            (TextOption::Jumps, self.jumps.as_ref()),
            (TextOption::Friction, self.friction.as_ref()),
            (TextOption::Bearing, self.bearing.as_ref()),
            (TextOption::CenterOfMass, self.center_of_mass.as_ref()),
        ];
        let numbers = numbers.into_iter().filter_map(|(option, v)| Some(GivenOption::Number(option, v?)));
        let texts = texts.into_iter().filter_map(|(option, text)| Some(GivenOption::Text(option, text?.clone())));
        Ok(PlateOptions::from_values(numbers.chain(texts))?)
    }
}

/// A scenario file, as against the number of an experiment.
fn is_file(what: &Path) -> bool {
    what.extension().is_some_and(|e| e == "toml") || what.exists()
}

/// Runs the experiment and writes what it gave.
pub(crate) fn run(args: &PlateArgs, output: &CommonArgs) -> anyhow::Result<Outcome> {
    args.page.check(output)?;
    let scenario = args.scenario()?;
    let log = args.compare.as_deref().map(PlateLog::read).transpose()?;
    if args.motion == MotionArg::Log && log.is_none() {
        anyhow::bail!("--motion log: no log is given; add --compare LOG.csv");
    }
    if args.noise.is_some() && log.is_none() {
        anyhow::bail!("--noise: no log is given; add --compare LOG.csv");
    }
    if args.gif && output.out.is_none() {
        anyhow::bail!("--gif: no folder is given; add --out DIR");
    }
    let setup = args.options()?.or(scenario).setup(log.as_ref())?;
    let progress = spinner("simulating the plate");
    let end = setup.end();
    let ran = PlateExperiment::new(setup, log, args.motion == MotionArg::Log, |t| {
        progress.set_message(format!("simulating the plate, {t:.1} of {end:.1} s"));
        ControlFlow::Continue(())
    })?;
    progress.finish_and_clear();
    let mut written = Vec::new();
    if let Some(dir) = &output.out {
        folder(dir)?;
        let progress = spinner("drawing");
        written = files::write_all(dir, &ran, args.gif)?;
        progress.finish_and_clear();
        args.page.open(&dir.join(files::PAGE));
    }
    if output.json {
        print(&json(&plate::json(&ran))?)?;
    } else {
        print(&plate::text(&ran))?;
        match &output.out {
            Some(dir) => line(&format!("written to {}: {}", dir.display(), written.join(", ")))?,
            None => line("(--out DIR writes a page with plots and the trajectory, with --gif an animation)")?,
        }
    }
    let undecided = ran.comparison.as_ref().is_some_and(Comparison::is_undecided);
    Ok(if ran.outcome() == PlateOutcome::Reached && !undecided { Outcome::Done } else { Outcome::Negative })
}
