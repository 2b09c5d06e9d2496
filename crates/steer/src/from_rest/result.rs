//! What is asked, and what was found.

use std::time::Duration;

use bracketry_symbolic::StopFlag;
use serde::Serialize;

use super::bounds::Bound;
use super::grid::Grid;
use super::held::{Cone, Motion};
use super::meeting::Return;
use super::reason::FromRestReason;
use super::strokes::Shape;
use crate::signals::Signals;

/// Bounds and limits.
#[derive(Clone, Debug)]
pub struct FromRestOptions {
    /// Bounds of inputs, of their derivatives, and of coordinates, beside the ranges of the model. The highest derivative of every
    /// input that the equations use needs one.
    pub bounds: Vec<Bound>,
    /// Wall-clock time after which no further loop is tried.
    pub time_limit: Option<Duration>,
    /// Once it is raised, the search ends.
    pub stop: StopFlag,
}

impl Default for FromRestOptions {
    fn default() -> Self {
        FromRestOptions { bounds: Vec::new(), time_limit: Some(Duration::from_mins(2)), stop: StopFlag::default() }
    }
}

/// What a "yes" rests on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Proof {
    /// Exact inequalities over the values that the inputs take along the loops.
    Proven,
    /// Simulated displacements, whose directions positively span the coordinates with a margin.
    Evidence,
}

/// Whether the rest states near the point are reached from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "answer")]
pub enum Answer {
    /// Some are not: a coordinate does not change, or changes in one direction only.
    No,
    /// All are.
    Yes {
        /// How this is known.
        proof: Proof,
    },
    /// Neither was shown.
    Unknown,
}

/// How a coordinate can change from rest to rest.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoordinateAnswer {
    /// Its name.
    pub name: String,
    /// Its value at the point.
    pub at: f64,
    /// What was excluded for all admissible inputs.
    pub motion: Motion,
    /// Whether it changes in both directions.
    #[serde(flatten)]
    pub answer: Answer,
}

/// A displacement by a loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Displacement {
    /// Durations relative to the full loop.
    pub scale: f64,
    /// Changes of the coordinates.
    pub change: Vec<f64>,
}

/// A loop of the inputs with its displacements.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The inputs that move.
    pub inputs: Vec<String>,
    /// Its shape.
    pub shape: Shape,
    /// Length of the loop without the pause, s.
    pub duration: f64,
    /// Displacements of the loop and of shorter ones.
    pub displacements: Vec<Displacement>,
    /// The only coordinate that it changes, and the sign, if this is proven.
    pub proven: Option<(usize, f64)>,
    /// The highest derivatives of the inputs over time, with the pause.
    pub signals: Signals,
}

/// What can be reached from rest to rest.
#[derive(Clone, Debug)]
pub struct FromRest {
    /// The model.
    pub model: String,
    /// The answer for all coordinates together.
    pub answer: Answer,
    /// Why there is no answer.
    pub reason: Option<FromRestReason>,
    /// The answer for each coordinate.
    pub coordinates: Vec<CoordinateAnswer>,
    /// The bounds that hold, also those that follow from others.
    pub bounds: Vec<Bound>,
    /// The friction forces.
    pub cones: Vec<Cone>,
    /// The loops that displace a coordinate.
    pub strokes: Vec<Stroke>,
    /// The largest set of coordinates that the loops positively span without a change of the others, by place in `coordinates`.
    pub moving: Vec<usize>,
    /// Sizes of displacements by which directions are made comparable, by coordinate.
    pub sizes: Vec<f64>,
    /// By loop, the direction of its displacement over the moving coordinates, in units of the sizes, of length 1; zeros if it
    /// changes others, too.
    pub directions: Vec<Vec<f64>>,
    /// Radius of the ball about 0 in the hull of these directions.
    pub margin: f64,
    /// How far the margin carries, over the bounds of the coordinates; `None` without loops, or where this was not found in time.
    pub grid: Option<Grid>,
    /// Loops that return to the point, and how their durations move the end; `None` if there are none.
    pub back: Option<Return>,
}
