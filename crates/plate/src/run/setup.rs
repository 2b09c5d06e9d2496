//! What is run: an experiment, a model of the contact, an object and its friction.

use serde::Serialize;

use crate::experiment::Experiment;
use crate::{Friction, Object};

/// How object and plate touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PlateModel {
    /// As published: per-axis friction, no yaw friction, no centrifugal and thickness terms.
    Published,
    /// First principles with the friction of one point of contact under the center of mass.
    Point,
    /// The area contact reduced to an ordinary differential equation with yaw friction.
    Reduced,
    /// Friction over the whole footprint, under the pressure that the balance of moments asks for.
    Area,
    /// The same; what tips or lifts off goes on as a free rigid body.
    Body,
}

impl PlateModel {
    /// All models.
    pub const ALL: [Self; 5] = [Self::Published, Self::Point, Self::Reduced, Self::Area, Self::Body];

    /// What it is called in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Published => "published",
            Self::Point => "point",
            Self::Reduced => "reduced",
            Self::Area => "area",
            Self::Body => "body",
        }
    }
}

/// One experiment to be run on one model.
#[derive(Clone, Debug)]
pub struct PlateSetup {
    /// What the plate does and where the object should go.
    pub experiment: Experiment,
    /// How object and plate touch.
    pub model: PlateModel,
    /// The object.
    pub object: Object,
    /// The law of friction.
    pub friction: Friction,
    /// Where the object starts, at rest on the plate: x, y (m) and yaw (rad).
    pub start: [f64; 3],
    /// Time of the start in seconds; the inputs of the experiment begin there.
    pub from: f64,
    /// Duration in seconds.
    pub seconds: f64,
    /// Points of contact of the area model.
    pub points: usize,
    /// Time step of the models with time stepping, in seconds.
    pub dt: f64,
    /// Restitution of impacts of the body model.
    pub restitution: f64,
    /// Time between two rows of the result, in seconds.
    pub sample: f64,
    /// Standard deviation of the noise of a log in the coordinate that the experiment moves (m, rad), if it is known.
    pub noise: Option<f64>,
}

impl PlateSetup {
    /// End of the run, in seconds.
    pub fn end(&self) -> f64 {
        self.from + self.seconds
    }

    /// Index of the coordinate that the experiment moves.
    pub fn coordinate(&self) -> usize {
        self.experiment.index()
    }

    /// Where the object should go, x, y (m) and yaw (rad); the coordinates that the experiment does not move as at the start.
    pub fn target(&self) -> [f64; 3] {
        let mut pose = self.start;
        pose[self.coordinate()] = self.experiment.target;
        pose
    }
}
