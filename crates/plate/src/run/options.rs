//! What a run can be told, on the command line, in a scenario file or from Python, and the setup that it asks for.

use std::path::Path;

use bracketry_files::{Document, FileError};

use super::bearing_option as bearings;
use super::option_text::{Problem, problem};
use super::option_values::{self as values, ExperimentKind, FrictionLaw};
use super::setup::{PlateModel, PlateSetup};
use crate::experiment::{AmplitudeStep, Coordinate, Experiment};
use crate::object::Bearing;
use crate::{Friction, Object, PlateLog, Shape};

/// Most rows of a result.
const MAX_ROWS: f64 = 2e6;
/// Most steps of a run.
const MAX_STEPS: f64 = 2e7;

/// What a run is told; what is absent has a default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlateOptions {
    /// The experiment.
    pub experiment: Option<ExperimentKind>,
    /// Frequency of experiment 2, ω in units of π.
    pub omega: Option<u32>,
    /// How object and plate touch.
    pub model: Option<PlateModel>,
    /// The outline of the object.
    pub shape: Option<Shape>,
    /// Thickness in meters.
    pub thickness: Option<f64>,
    /// Mass in kg.
    pub mass: Option<f64>,
    /// Where the object presses on the plate.
    pub bearing: Option<Bearing>,
    /// The center of mass from the center of the shape in meters.
    pub center_of_mass: Option<[f64; 2]>,
    /// Friction coefficient of sliding.
    pub mu: Option<f64>,
    /// What the law of friction has beside the coefficient of sliding.
    pub friction: Option<FrictionLaw>,
    /// x, y (m) and yaw (rad), at rest.
    pub start: Option<[f64; 3]>,
    /// Duration in seconds.
    pub seconds: Option<f64>,
    /// Points of contact.
    pub points: Option<usize>,
    /// Time step in seconds.
    pub dt: Option<f64>,
    /// Restitution.
    pub restitution: Option<f64>,
    /// What happens where the amplitude changes.
    pub jumps: Option<AmplitudeStep>,
    /// Seconds between the rows of the result.
    pub sample: Option<f64>,
    /// Standard deviation of the noise of the log in the coordinate that the experiment moves, in m or rad.
    pub noise: Option<f64>,
}

/// Defines options whose values are of one kind, with their names.
macro_rules! option_names {
    ($(#[$about:meta])* $kind:ident { $($(#[$what:meta])* $option:ident = $name:literal,)* }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $kind {
            $($(#[$what])* $option,)*
        }

        impl $kind {
            /// All of them, in the order in which they are read.
            pub const ALL: &'static [Self] = &[$(Self::$option,)*];

            /// The name on the command line, in a scenario file, and in Python.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$option => $name,)*
                }
            }
        }
    };
}

option_names! {
    /// An option with a number as its value.
    NumberOption {
        /// ω of experiment 2 in units of π.
        Omega = "omega",
        /// m.
        Thickness = "thickness",
        /// kg.
        Mass = "mass",
        /// Of sliding.
        Mu = "mu",
        /// Duration, s.
        Seconds = "seconds",
        /// Of contact.
        Points = "points",
        /// Time step, s.
        Dt = "dt",
        /// 0 to 1.
        Restitution = "restitution",
        /// Time between rows, s.
        Sample = "sample",
        /// Standard deviation of a log's noise, m or rad.
        Noise = "noise",
    }
}

option_names! {
    /// An option with a text as its value.
    TextOption {
        /// 1, 2 or 3.
        Experiment = "experiment",
        /// See [`PlateModel`].
        Model = "model",
        /// `disk:R`, `ellipse:AxB` (semi-axes), `rectangle:AxB` (full sides) or `polygon:FILE.csv`, in meters.
        Shape = "shape",
        /// `x,y,phi` in meters and radians, or degrees with `deg`.
        Start = "start",
        /// `world` or `smooth`.
        Jumps = "jumps",
        /// `coulomb`, `static:MU_S`, `stribeck:MU_S,V`, `anisotropic:MU_Y` or `viscous:C`.
        Friction = "friction",
        /// `footprint`, `scaled:F`, `ring:S`, `feet:x,y;x,y;…` or `map:FILE.csv`, in meters.
        Bearing = "bearing",
        /// `x,y` in meters.
        CenterOfMass = "center_of_mass",
    }
}

/// An option with its value as it is given.
#[derive(Clone, Debug, PartialEq)]
pub enum GivenOption {
    /// A number.
    Number(NumberOption, f64),
    /// A text.
    Text(TextOption, String),
}

impl GivenOption {
    /// The name of the option.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Number(option, _) => option.name(),
            Self::Text(option, _) => option.name(),
        }
    }
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

/// An error at an option of the command line.
fn at_option(name: &str, (message, remedy): Problem) -> SetupError {
    SetupError::Value { place: format!("--{}", name.replace('_', "-")), message, remedy }
}

impl PlateOptions {
    /// The options of these values; the first that has no meaning is reported.
    ///
    /// # Errors
    /// [`SetupError::Value`] with the option, what is wrong and what to do.
    pub fn from_values(given: impl IntoIterator<Item = GivenOption>) -> Result<Self, SetupError> {
        let mut options = Self::default();
        for value in given {
            options.set(&value).map_err(|p| at_option(value.name(), p))?;
        }
        Ok(options)
    }

    fn set(&mut self, given: &GivenOption) -> Result<(), Problem> {
        match given {
            GivenOption::Number(option, v) => self.set_number(*option, *v),
            GivenOption::Text(option, text) => self.set_text(*option, text),
        }
    }

    fn set_number(&mut self, option: NumberOption, v: f64) -> Result<(), Problem> {
        let name = option.name();
        match option {
            NumberOption::Omega => self.omega = Some(values::omega(v)?),
            NumberOption::Thickness => self.thickness = Some(values::not_negative(name, v, "m")?),
            NumberOption::Mass => self.mass = Some(values::positive(name, v, "kg")?),
            NumberOption::Mu => self.mu = Some(values::not_negative(name, v, "")?),
            NumberOption::Seconds => self.seconds = Some(values::positive(name, v, "s")?),
            NumberOption::Points => self.points = Some(values::points(v)?),
            NumberOption::Dt => self.dt = Some(values::step(v)?),
            NumberOption::Restitution => self.restitution = Some(values::restitution(v)?),
            NumberOption::Sample => self.sample = Some(values::sample(v)?),
            NumberOption::Noise => self.noise = Some(values::not_negative(name, v, "m or rad")?),
        }
        Ok(())
    }

    fn set_text(&mut self, option: TextOption, text: &str) -> Result<(), Problem> {
        match option {
            TextOption::Experiment => self.experiment = Some(values::experiment(text)?),
            TextOption::Model => self.model = Some(values::model(text)?),
            TextOption::Shape => self.shape = Some(values::shape(text)?),
            TextOption::Start => self.start = Some(values::start(text)?),
            TextOption::Jumps => self.jumps = Some(values::amplitude_step(text)?),
            TextOption::Friction => self.friction = Some(values::friction(text)?),
            TextOption::Bearing => self.bearing = Some(bearings::bearing(text)?),
            TextOption::CenterOfMass => self.center_of_mass = Some(bearings::center_of_mass(text)?),
        }
        Ok(())
    }

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
        let (numbers, texts) = (NumberOption::ALL.iter(), TextOption::ALL.iter());
        let known: Vec<&str> = texts.clone().map(|o| o.name()).chain(numbers.clone().map(|o| o.name())).collect();
        doc.only_keys(&table, &known, "a plate scenario")?;
        let mut given = Vec::new();
        for &option in numbers {
            given.extend(doc.number(&table, option.name())?.map(|v| GivenOption::Number(option, v)));
        }
        for &option in texts {
            let name = option.name();
            let number =
                option == TextOption::Experiment && table.get(name).is_some_and(|v| v.get_ref().as_integer().is_some());
            let text =
                if number { doc.number(&table, name)?.map(|v| v.to_string()) } else { doc.string(&table, name)? };
            let text = text.map(|text| beside(folder, text));
            given.extend(text.map(|text| GivenOption::Text(option, text)));
        }
        let mut options = Self::default();
        for (key, value) in &table {
            let name: &str = key.get_ref();
            let set = given.iter().find(|option| option.name() == name).map_or(Ok(()), |option| options.set(option));
            set.map_err(|(message, remedy)| doc.error(value.span(), message, remedy))?;
        }
        if let (Err((message, remedy)), Some(law)) = (options.friction(), table.get("friction")) {
            return Err(doc.error(law.span(), message, remedy).into());
        }
        Ok(options)
    }

    /// These options where they are given, `others` where not.
    #[must_use]
    pub fn or(self, others: Self) -> Self {
        Self {
            experiment: self.experiment.or(others.experiment),
            omega: self.omega.or(others.omega),
            model: self.model.or(others.model),
            shape: self.shape.or(others.shape),
            thickness: self.thickness.or(others.thickness),
            mass: self.mass.or(others.mass),
            bearing: self.bearing.or(others.bearing),
            center_of_mass: self.center_of_mass.or(others.center_of_mass),
            mu: self.mu.or(others.mu),
            friction: self.friction.or(others.friction),
            start: self.start.or(others.start),
            seconds: self.seconds.or(others.seconds),
            points: self.points.or(others.points),
            dt: self.dt.or(others.dt),
            restitution: self.restitution.or(others.restitution),
            jumps: self.jumps.or(others.jumps),
            sample: self.sample.or(others.sample),
            noise: self.noise.or(others.noise),
        }
    }

    /// The setup that these options ask for. A log gives duration and start where they are not given.
    ///
    /// # Errors
    /// [`SetupError::Value`] with the option, what is wrong and what to do.
    pub fn setup(&self, log: Option<&PlateLog>) -> Result<PlateSetup, SetupError> {
        let friction = self.friction().map_err(|p| at_option("friction", p))?;
        let experiment = self.experiment().with_amplitude_step(self.jumps.unwrap_or_default());
        let start = self.start.or(log.map(|l| [l.x[0], l.y[0], l.phi[0]])).unwrap_or(match experiment.coordinate {
            Coordinate::X => [experiment.start, 0.0, 0.0],
            Coordinate::Y => [0.3, experiment.start, 0.0],
            Coordinate::Phi => [0.3, 0.0, experiment.start],
        });
        let from = log.map_or(0.0, |l| l.t[0]);
        let seconds = self.seconds.or(log.map(|l| l.t[l.t.len() - 1] - from)).unwrap_or(15.0);
        let (sample, dt) = (self.sample.unwrap_or(2e-3), self.dt.unwrap_or(5e-4));
        if seconds / dt > MAX_STEPS {
            let message = format!("more than {MAX_STEPS:.0} steps would be taken");
            return Err(at_option("dt", problem(message, "enlarge --dt or shorten --seconds")));
        }
        if seconds / sample > MAX_ROWS {
            let message = format!("more than {MAX_ROWS:.0} rows would be written");
            return Err(at_option("seconds", problem(message, "enlarge --sample")));
        }
        let points = self.points.unwrap_or(48);
        Ok(PlateSetup {
            experiment,
            model: self.model.unwrap_or(PlateModel::Area),
            object: self.object(points)?,
            friction,
            start,
            from,
            seconds,
            points,
            dt,
            restitution: self.restitution.unwrap_or(0.0),
            sample,
            noise: self.noise,
        })
    }

    fn object(&self, points: usize) -> Result<Object, SetupError> {
        let object = Object {
            shape: self.shape.clone().unwrap_or(Shape::REFERENCE_DISK),
            height: 0.5 * self.thickness.unwrap_or(0.005),
            mass: self.mass.unwrap_or(0.2),
            bearing: self.bearing.clone().unwrap_or_default(),
            center_of_mass: self.center_of_mass.unwrap_or_default(),
        };
        if self.bearing.is_some() {
            bearings::check_bearing(&object, points).map_err(|p| at_option(TextOption::Bearing.name(), p))?;
        }
        bearings::check_center_of_mass(&object).map_err(|p| at_option(TextOption::CenterOfMass.name(), p))?;
        Ok(object)
    }

    fn experiment(&self) -> Experiment {
        match self.experiment.unwrap_or(ExperimentKind::Orientation) {
            ExperimentKind::Orientation => Experiment::orientation(),
            ExperimentKind::TranslationX => Experiment::translation_x(self.omega.unwrap_or(3)),
            ExperimentKind::TranslationY => Experiment::translation_y(),
        }
    }

    fn friction(&self) -> Result<Friction, Problem> {
        let law = self.friction.unwrap_or(FrictionLaw::Coulomb).sliding_at(self.mu.unwrap_or(0.3));
        law.validate().map_err(|e| problem(e.to_string(), "correct --mu or --friction"))?;
        Ok(law)
    }
}

/// A text of a scenario file; the file that it names lies beside the scenario.
fn beside(folder: Option<&Path>, text: String) -> String {
    let named =
        ["polygon", "map"].into_iter().find_map(|kind| Some((kind, text.strip_prefix(kind)?.strip_prefix(':')?)));
    match (named, folder) {
        (Some((kind, file)), Some(folder)) if Path::new(file).is_relative() => {
            format!("{kind}:{}", folder.join(file).display())
        }
        _ => text,
    }
}
