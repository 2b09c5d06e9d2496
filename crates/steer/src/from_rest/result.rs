//! What is asked, and what was found.

use std::time::Duration;

use bracketry_symbolic::StopFlag;
use serde::Serialize;

use super::bounds::Bound;
use super::held::{Cone, Motion};
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
}

/// Why there is no answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "reason")]
pub enum FromRestReason {
    /// No state is a coordinate: one whose rate vanishes at rest whatever the inputs.
    NoCoordinates,
    /// No dry friction acts on a velocity.
    NoFriction,
    /// Inputs act with a delay.
    Delays,
    /// The model in affine form has other inputs.
    Inputs,
    /// The point is not a rest state: friction does not hold it there with the inputs at their values.
    NotAtRest,
    /// A sign of something else than velocities.
    OtherSwitch {
        /// The switching function.
        name: String,
    },
    /// The loops that were tried do not positively span the coordinates.
    Loops {
        /// Loops that were tried.
        tried: usize,
    },
    /// The time limit was reached, or it was asked to stop.
    Stopped,
}

impl std::fmt::Display for FromRestReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoCoordinates => write!(f, "no state keeps its value at rest whatever the inputs"),
            Self::NoFriction => {
                write!(f, "no dry friction acts on a velocity: the other verdicts on controllability apply")
            }
            Self::Delays => write!(f, "inputs act with a delay: analyze the model without it"),
            Self::Inputs => write!(f, "the model with integrators in front of the inputs has other inputs"),
            Self::NotAtRest => {
                write!(f, "friction is not shown to hold the state at the point; choose a point at rest")
            }
            Self::OtherSwitch { name } => write!(f, "the equations switch with {name}, which is no velocity"),
            Self::Loops { tried } => {
                write!(f, "the displacements of {tried} loops do not positively span the coordinates; try wider bounds")
            }
            Self::Stopped => write!(f, "the time limit was reached"),
        }
    }
}

/// Misuse.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FromRestError {
    /// A text that gives no bound.
    #[error("`{text}` is not a bound: write NAME=LOW..HIGH, such as der(X,2)=-4..4")]
    Bound {
        /// The text.
        text: String,
    },
    /// A bound of something unknown.
    #[error("`{name}` has no bounds here: give bounds of {}", .known.join(", "))]
    Unknown {
        /// The name.
        name: String,
        /// What may have bounds.
        known: Vec<String>,
    },
    /// Two bounds of the same thing.
    #[error("`{name}` has two bounds: remove one")]
    Twice {
        /// The name.
        name: String,
    },
    /// The highest derivative of an input is not bounded.
    #[error("`{name}` is not bounded: give its bounds, as in {name}=-4..4")]
    Unbounded {
        /// The derivative.
        name: String,
    },
    /// Bounds that exclude rest.
    #[error("the bounds of `{name}` exclude its value at rest, {rest}: widen them, or change the point")]
    RestOutside {
        /// The name.
        name: String,
        /// Its value at rest.
        rest: f64,
    },
    /// An axis of a map that is no bound of an input.
    #[error(
        "the axis `{name}` of the map: give an input or one of its derivatives, as in {name}=0.1..2, and at least one cell"
    )]
    Axis {
        /// The name.
        name: String,
    },
    /// A coordinate whose value at the point is no number.
    #[error("`{name}` has no finite value at the point: give one")]
    Point {
        /// The coordinate.
        name: String,
    },
    /// The model cannot be simulated.
    #[error(transparent)]
    Input(#[from] bracketry_sim::InputError),
    /// Derivatives of inputs that cannot be replaced by integrators.
    #[error(transparent)]
    Affine(#[from] bracketry_system::AffineError),
    /// The equations divide by zero everywhere.
    #[error(transparent)]
    Denominator(#[from] bracketry_system::ZeroDenominator),
}
