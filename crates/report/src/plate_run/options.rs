//! What a run can be told, on the command line or in a scenario file, and what it becomes.

use std::path::{Path, PathBuf};

use bracketry_plate::{AmplitudeStep, Experiment, Friction, Object, PlateError, Shape};
use bracketry_system::{Document, FileError};

use super::{MAX_ROWS, MAX_SAMPLE, MAX_STEP, MAX_STEPS, PlateLog, PlateModel, PlateSetup};

/// What a run is told; what is absent has a default. Texts are as on the command line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlateOptions {
    /// 1 (orientation), 2 (along x) or 3 (along y).
    pub experiment: Option<String>,
    /// Frequency of experiment 2, ω in units of π.
    pub omega: Option<f64>,
    /// Name of the model.
    pub model: Option<String>,
    /// `disk:R`, `ellipse:AxB` (semi-axes), `rectangle:AxB` (full sides), `polygon:FILE.csv`; metres.
    pub shape: Option<String>,
    /// Thickness in metres.
    pub thickness: Option<f64>,
    /// Mass in kg.
    pub mass: Option<f64>,
    /// Friction coefficient of sliding.
    pub mu: Option<f64>,
    /// `coulomb`, `static:MU_S`, `stribeck:MU_S,V`, `anisotropic:MU_Y`, `viscous:C`.
    pub friction: Option<String>,
    /// `x,y,phi`: metres and radians, or degrees with `deg`.
    pub start: Option<String>,
    /// Duration in seconds.
    pub seconds: Option<f64>,
    /// Points of contact.
    pub points: Option<f64>,
    /// Time step in seconds.
    pub dt: Option<f64>,
    /// Restitution.
    pub restitution: Option<f64>,
    /// `world` or `smooth`: what happens where the amplitude changes.
    pub jumps: Option<String>,
    /// Seconds between the rows of the result.
    pub sample: Option<f64>,
}

/// A run that cannot be set up: where the reason lies, what it is and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SetupError {
    /// A value without meaning.
    #[error("{place}: {message}; {remedy}")]
    Value {
        /// The option, or place in the file.
        place: String,
        /// What is wrong.
        message: String,
        /// What to do.
        remedy: String,
    },
    /// A file.
    #[error(transparent)]
    File(#[from] FileError),
}

/// A message and what to do.
type Problem = (String, String);

fn problem(message: impl Into<String>, remedy: impl Into<String>) -> Problem {
    (message.into(), remedy.into())
}

const TEXTS: [&str; 6] = ["experiment", "model", "shape", "start", "jumps", "friction"];
const NUMBERS: [&str; 9] = ["omega", "thickness", "mass", "mu", "seconds", "points", "dt", "restitution", "sample"];

impl PlateOptions {
    /// Reads a scenario file: a table with the options by name; numbers as numbers, the others as texts (`experiment` may
    /// be a number).
    ///
    /// # Errors
    /// [`SetupError`] with place and remedy.
    pub fn read(path: &Path) -> Result<Self, SetupError> {
        Self::from_document(&Document::read(path)?, path.parent())
    }

    fn from_document(doc: &Document, folder: Option<&Path>) -> Result<Self, SetupError> {
        let table = doc.table()?;
        let known: Vec<&str> = TEXTS.into_iter().chain(NUMBERS).collect();
        doc.only_keys(&table, &known, "a plate scenario")?;
        let mut options = Self::default();
        for name in NUMBERS {
            *options.number(name) = doc.number(&table, name)?;
        }
        for name in TEXTS {
            let number = name == "experiment" && table.get(name).is_some_and(|v| v.get_ref().as_integer().is_some());
            *options.text(name) =
                if number { doc.number(&table, name)?.map(|v| v.to_string()) } else { doc.string(&table, name)? };
        }
        // A polygon's file lies beside the scenario.
        if let (Some(file), Some(folder)) = (options.shape.as_deref().and_then(|s| s.strip_prefix("polygon:")), folder)
            && Path::new(file).is_relative()
        {
            options.shape = Some(format!("polygon:{}", folder.join(file).display()));
        }
        for (key, value) in &table {
            let name: &str = key.get_ref();
            if let Err((message, remedy)) = options.check(name) {
                return Err(doc.error(value.span(), message, remedy).into());
            }
        }
        Ok(options)
    }

    fn text(&mut self, name: &str) -> &mut Option<String> {
        match name {
            "experiment" => &mut self.experiment,
            "model" => &mut self.model,
            "shape" => &mut self.shape,
            "friction" => &mut self.friction,
            "start" => &mut self.start,
            _ => &mut self.jumps,
        }
    }

    fn number(&mut self, name: &str) -> &mut Option<f64> {
        match name {
            "omega" => &mut self.omega,
            "thickness" => &mut self.thickness,
            "mass" => &mut self.mass,
            "mu" => &mut self.mu,
            "seconds" => &mut self.seconds,
            "points" => &mut self.points,
            "dt" => &mut self.dt,
            "restitution" => &mut self.restitution,
            _ => &mut self.sample,
        }
    }

    /// These options where they are given, `others` where not.
    #[must_use]
    pub fn or(mut self, mut others: Self) -> Self {
        for name in TEXTS {
            let other = others.text(name).take();
            let own = self.text(name);
            *own = own.take().or(other);
        }
        for name in NUMBERS {
            let own = self.number(name).or(*others.number(name));
            *self.number(name) = own;
        }
        self
    }

    /// Whether one option has a meaning by itself.
    fn check(&self, name: &str) -> Result<(), Problem> {
        match name {
            "experiment" => self.the_experiment().map(|_| ()),
            "omega" => self.the_omega().map(|_| ()),
            "model" => self.the_model().map(|_| ()),
            "shape" => self.the_shape().map(|_| ()),
            "mu" => at_least_zero("mu", self.mu, ""),
            "friction" => self.the_friction().map(|_| ()),
            "start" => self.the_start().map(|_| ()),
            "jumps" => self.the_jumps().map(|_| ()),
            "thickness" => at_least_zero("thickness", self.thickness, "m"),
            "restitution" => match self.restitution {
                Some(e) if !(0.0..=1.0).contains(&e) => {
                    Err(problem(format!("restitution = {e} is outside 0 to 1"), "give 0 (no rebound) to 1"))
                }
                _ => Ok(()),
            },
            "points" => match self.points {
                Some(n) if n.fract() != 0.0 || !(4.0..=100_000.0).contains(&n) => {
                    Err(problem(format!("points = {n} is not a count from 4 to 100000"), "48 are usually enough"))
                }
                _ => Ok(()),
            },
            "mass" => positive("mass", self.mass, "kg"),
            "seconds" => positive("seconds", self.seconds, "s"),
            // Rows give time to target, shares and extremes: they must be close to each other.
            "sample" => at_most("sample", self.sample, MAX_SAMPLE),
            "dt" => at_most("dt", self.dt, MAX_STEP),
            _ => Ok(()),
        }
    }

    /// The setup that these options ask for. A log gives duration and start where they are not given.
    ///
    /// # Errors
    /// [`SetupError::Value`] with the option, what is wrong and what to do.
    pub fn setup(&self, log: Option<&PlateLog>) -> Result<PlateSetup, SetupError> {
        let placed =
            |name: &str, (message, remedy): Problem| SetupError::Value { place: format!("--{name}"), message, remedy };
        for name in NUMBERS.into_iter().chain(TEXTS) {
            self.check(name).map_err(|p| placed(name, p))?;
        }
        let mut experiment = self.the_experiment().map_err(|p| placed("experiment", p))?;
        experiment.step = self.the_jumps().map_err(|p| placed("jumps", p))?;
        let given = self.the_start().map_err(|p| placed("start", p))?;
        let start = given.or(log.map(|l| [l.x[0], l.y[0], l.phi[0]])).unwrap_or(match experiment.coordinate {
            "x" => [experiment.start, 0.0, 0.0],
            "y" => [0.3, experiment.start, 0.0],
            _ => [0.3, 0.0, experiment.start],
        });
        let from = log.map_or(0.0, |l| l.t[0]);
        let seconds = self.seconds.or(log.map(|l| l.t[l.t.len() - 1] - from)).unwrap_or(15.0);
        let sample = self.sample.unwrap_or(2e-3);
        let dt = self.dt.unwrap_or(5e-4);
        if seconds / dt > MAX_STEPS {
            let p =
                problem(format!("more than {MAX_STEPS:.0} steps would be taken"), "enlarge --dt or shorten --seconds");
            return Err(placed("dt", p));
        }
        if seconds / sample > MAX_ROWS {
            let p = problem(format!("more than {MAX_ROWS:.0} rows would be written"), "enlarge --sample");
            return Err(placed("seconds", p));
        }
        let setup = PlateSetup {
            experiment,
            model: self.the_model().map_err(|p| placed("model", p))?,
            object: Object {
                shape: self.the_shape().map_err(|p| placed("shape", p))?,
                height: 0.5 * self.thickness.unwrap_or(0.005),
                mass: self.mass.unwrap_or(0.2),
            },
            friction: self.the_friction().map_err(|p| placed("friction", p))?,
            start,
            from,
            seconds,
            points: self.points.unwrap_or(48.0) as usize,
            dt,
            restitution: self.restitution.unwrap_or(0.0),
            sample,
        };
        Ok(setup)
    }

    fn the_omega(&self) -> Result<u32, Problem> {
        let omega = self.omega.unwrap_or(3.0);
        if omega.fract() == 0.0 && (1.0..=20.0).contains(&omega) {
            return Ok(omega as u32);
        }
        Err(problem(
            format!("omega = {omega} is not a whole number from 1 to 20"),
            "give ω in units of π, such as 3 or 4",
        ))
    }

    fn the_experiment(&self) -> Result<Experiment, Problem> {
        match self.experiment.as_deref().unwrap_or("1") {
            "1" => Ok(Experiment::orientation()),
            "2" => Ok(Experiment::translation_x(self.the_omega()?)),
            "3" => Ok(Experiment::translation_y()),
            other => Err(problem(
                format!("there is no experiment `{other}`"),
                "name 1 (orientation), 2 (along x), 3 (along y), or a scenario file that exists",
            )),
        }
    }

    fn the_model(&self) -> Result<PlateModel, Problem> {
        let name = self.model.as_deref().unwrap_or(DEFAULT_MODEL);
        PlateModel::ALL.iter().find(|(known, _)| *known == name).map(|(_, model)| *model).ok_or_else(|| {
            let known: Vec<&str> = PlateModel::ALL.iter().map(|(name, _)| *name).collect();
            problem(format!("there is no model `{name}`"), format!("name one of {}", known.join(", ")))
        })
    }

    fn the_jumps(&self) -> Result<AmplitudeStep, Problem> {
        match self.jumps.as_deref() {
            None | Some("world") => Ok(AmplitudeStep::WorldFixed),
            Some("smooth") => Ok(AmplitudeStep::Smooth),
            Some(other) => Err(problem(
                format!("`{other}` is no way to change the amplitude"),
                "name world (the plate jumps, the object stays in the world) or smooth (no jump)",
            )),
        }
    }

    fn the_friction(&self) -> Result<Friction, Problem> {
        let mu = self.mu.unwrap_or(0.3);
        let text = self.friction.as_deref().unwrap_or("coulomb");
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        let numbers = numbers(rest)?;
        let law = match (kind.trim(), numbers.as_slice()) {
            ("coulomb", []) => Friction::Coulomb { mu },
            ("static", [mu_static]) => Friction::StaticLevel { mu, mu_static: *mu_static },
            ("stribeck", [mu_static, velocity]) => {
                Friction::Stribeck { mu, mu_static: *mu_static, velocity: *velocity }
            }
            ("anisotropic", [across]) => Friction::Anisotropic { mu_along: mu, mu_across: *across },
            ("viscous", [coefficient]) => Friction::Viscous { mu, coefficient: *coefficient },
            _ => {
                return Err(problem(
                    format!("`{text}` is no law of friction"),
                    "give coulomb, static:MU_S, stribeck:MU_S,VELOCITY, anisotropic:MU_ALONG_Y or viscous:COEFFICIENT",
                ));
            }
        };
        law.validate().map_err(|e| problem(e.to_string(), "correct --mu or --friction"))?;
        Ok(law)
    }

    fn the_start(&self) -> Result<Option<[f64; 3]>, Problem> {
        let Some(text) = &self.start else { return Ok(None) };
        match numbers(text)?.as_slice() {
            [x, y, phi] => Ok(Some([*x, *y, *phi])),
            [x, y] => Ok(Some([*x, *y, 0.0])),
            other => Err(problem(
                format!("`{text}` has {} numbers", other.len()),
                "give x,y,phi in metres and radians, such as 0.3,0,0 or 0.3,0,45deg",
            )),
        }
    }

    fn the_shape(&self) -> Result<Shape, Problem> {
        let Some(text) = &self.shape else { return Ok(Shape::REFERENCE_DISK) };
        let unknown = || {
            problem(
                format!("`{text}` is no shape"),
                "give disk:RADIUS, ellipse:AxB (semi-axes), rectangle:AxB (full sides) or polygon:FILE.csv, in metres",
            )
        };
        let (kind, rest) = text.split_once(':').ok_or_else(unknown)?;
        let lengths = || -> Result<[f64; 2], Problem> {
            let (a, b) = rest.split_once(['x', '×']).ok_or_else(unknown)?;
            Ok([number(a)?, number(b)?])
        };
        let shape = match kind.trim() {
            "disk" => Shape::Disk { radius: number(rest)? },
            "ellipse" => {
                let [a, b] = lengths()?;
                Shape::Ellipse { a, b }
            }
            "rectangle" => {
                let [a, b] = lengths()?;
                Shape::Rectangle { a: 0.5 * a, b: 0.5 * b }
            }
            "polygon" => polygon(&PathBuf::from(rest))?,
            _ => return Err(unknown()),
        };
        let refused = |e: PlateError| problem(e.to_string(), "give lengths in metres greater than zero");
        shape.validate().map_err(refused)?;
        Ok(shape)
    }
}

/// The model where none is named.
const DEFAULT_MODEL: &str = "area";

/// A polygon from a table with columns x and y, or two columns without names, in metres.
fn polygon(path: &Path) -> Result<Shape, Problem> {
    let place = path.display();
    let remedy = "give a table with a row x,y in metres for each vertex, in order around the outline";
    let text = std::fs::read_to_string(path).map_err(|e| problem(format!("{place} cannot be read: {e}"), remedy))?;
    let mut vertices = Vec::new();
    let mut named = false;
    for (k, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let fields: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
        if vertices.is_empty() && !named && fields == ["x", "y"] {
            named = true;
            continue;
        }
        let at = |what: String| problem(format!("{place}, line {}: {what}", k + 1), remedy);
        let [x, y] = fields.as_slice() else {
            return Err(at(format!("`{line}` has {} entries, not 2", fields.len())));
        };
        let (x, y) = (number(x).map_err(|p| at(p.0))?, number(y).map_err(|p| at(p.0))?);
        vertices.push([x, y]);
    }
    // An outline that is closed by repeating its first vertex.
    if vertices.len() > 3 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    Shape::polygon(&vertices).map_err(|e| problem(format!("{place}: {e}"), remedy))
}

/// Numbers separated by commas; none for an empty text.
fn numbers(text: &str) -> Result<Vec<f64>, Problem> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    text.split(',').map(number).collect()
}

/// A finite number; with `deg` in degrees.
fn number(text: &str) -> Result<f64, Problem> {
    let text = text.trim();
    let (digits, factor) = match text.strip_suffix("deg").or(text.strip_suffix('°')) {
        Some(degrees) => (degrees.trim(), std::f64::consts::PI / 180.0),
        None => (text, 1.0),
    };
    match digits.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v * factor),
        _ => Err(problem(format!("`{text}` is not a finite number"), "write a decimal number such as 0.12")),
    }
}

/// ` of kg` and the like, nothing for a pure number.
fn of_unit(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" of {unit}") }
}

fn positive(name: &str, value: Option<f64>, unit: &str) -> Result<(), Problem> {
    match value {
        Some(v) if !(v.is_finite() && v > 0.0) => Err(problem(
            format!("{name} = {v} must be positive"),
            format!("give a number{} greater than zero", of_unit(unit)),
        )),
        _ => Ok(()),
    }
}

fn at_most(name: &str, value: Option<f64>, most: f64) -> Result<(), Problem> {
    match value {
        Some(v) if !(v > 0.0 && v <= most) => Err(problem(
            format!("{name} = {v} is not between 0 and {most} s"),
            "give a number of seconds, greater than zero and within this limit",
        )),
        _ => Ok(()),
    }
}

fn at_least_zero(name: &str, value: Option<f64>, unit: &str) -> Result<(), Problem> {
    match value {
        Some(v) if !(v.is_finite() && v >= 0.0) => Err(problem(
            format!("{name} = {v} must not be negative"),
            format!("give a number{}, 0 or greater", of_unit(unit)),
        )),
        _ => Ok(()),
    }
}
