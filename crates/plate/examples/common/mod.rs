//! What the examples with figures share: models by name, progress, the folder of the figures.

use anyhow::Context;
use bracketry_plate::area::{AreaContact, AreaSettings};
use bracketry_plate::experiment::{AmplitudeStep, Coordinate, Experiment, Limits, Summary, summarize};
use bracketry_plate::model::Terms;
use bracketry_plate::{
    AreaObject, DrivenObject, Friction, ModelObject, Object, PlateError, Shape, first_principles, published, reduced,
};
use bracketry_plot::Drawing;
use bracketry_sim::SimulationSettings;
use indicatif::{ProgressBar, ProgressStyle};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Starts of the experiments: 1 from x = 0.3 m, 2 and 3 from where they are published.
pub(crate) fn start(experiment: &Experiment) -> [f64; 6] {
    match experiment.coordinate {
        Coordinate::Phi => [0.3, 0.0, 0.0, 0.0, 0.0, 0.0],
        Coordinate::X | Coordinate::Y => [0.48, -0.03, 0.0, 0.0, 0.0, 0.0],
    }
}

/// Tolerances of the sweeps.
pub(crate) fn settings() -> SimulationSettings {
    SimulationSettings::default().with_tolerance(1e-7, 1e-9)
}

/// The ellipse of the reference results, 5 mm thick.
pub(crate) const ELLIPSE: Object = Object { shape: Shape::REFERENCE_ELLIPSE, ..Object::REFERENCE };

/// Models of the plate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Model {
    /// As published; its torque turns the other way round.
    Published,
    /// First principles, contact in one point.
    Point,
    /// The area contact reduced to a differential equation, with these terms.
    Reduced(Terms),
    /// Area contact.
    Area,
}

impl Model {
    /// The experiment as this model has to be given it: the published torque turns clockwise, so that its tilt is turned
    /// round, and it knows no jump of the plate.
    pub(crate) fn experiment(self, experiment: Experiment) -> Experiment {
        match self {
            Self::Published if experiment.coordinate == Coordinate::Phi => experiment.with_reversed_tilt(),
            Self::Published => experiment.with_amplitude_step(AmplitudeStep::Smooth),
            _ => experiment,
        }
    }

    /// Runs an experiment with the disk of the reference results.
    pub(crate) fn summary(self, experiment: &Experiment, mu: f64, duration: f64) -> Result<Summary, PlateError> {
        let (object, law, state) = (&Object::REFERENCE, Friction::Coulomb { mu }, start(experiment));
        let system = match self {
            Self::Area => {
                let settings = AreaSettings::default().with_step(2e-3).with_points(48);
                let mut plant = AreaObject::new(AreaContact::new(object, &law, &settings)?)?;
                plant.set_state(0.0, state)?;
                return summarize(experiment, &mut plant, duration, Limits::default());
            }
            Self::Published => published(&object.shape, mu)?,
            Self::Point => first_principles(object, &law, Terms::default())?,
            Self::Reduced(terms) => reduced(object, mu, terms)?,
        };
        summarize(experiment, &mut ModelObject::new(&system, state, &settings())?, duration, Limits::default())
    }
}

/// The reduced model of an object.
pub(crate) fn reduced_plant(
    object: &Object,
    terms: Terms,
    mu: f64,
    state: [f64; 6],
) -> Result<ModelObject, PlateError> {
    ModelObject::new(&reduced(object, mu, terms)?, state, &settings())
}

/// A progress bar for a sweep.
pub(crate) struct Progress(ProgressBar);

impl Progress {
    pub(crate) fn new(what: &str, runs: usize) -> Self {
        let bar = ProgressBar::new(runs as u64).with_message(what.to_owned());
        if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}") {
            bar.set_style(style);
        }
        Self(bar)
    }

    /// Tells the bar how many runs are done.
    pub(crate) fn tell(&self, done: usize) -> ControlFlow<()> {
        self.0.set_position(done as u64);
        ControlFlow::Continue(())
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

/// The folder for the figures: the first argument, or `docs/figures`.
pub(crate) fn folder() -> anyhow::Result<PathBuf> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/figures");
    let folder = std::env::args().nth(1).map_or(default, PathBuf::from);
    std::fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    Ok(folder)
}

/// Writes the PNG of a figure.
pub(crate) fn save(drawing: &Drawing, folder: &Path, name: &str) -> anyhow::Result<()> {
    let path = folder.join(format!("{name}.png"));
    std::fs::write(&path, drawing.png()?).with_context(|| format!("cannot write {}", path.display()))?;
    println!("{}", path.display());
    Ok(())
}
