//! What was found.

use bracketry_lie::Undecided;
use bracketry_lie::forms::NoChainedForm;
use bracketry_sim::Simulation;
use bracketry_symbolic::Function;
use bracketry_system::System;
use serde::Serialize;

use crate::from_rest::{FromRestError, FromRestReason};
use crate::options::SteerMethod;
use crate::signals::Signals;

/// How far it went.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SteerStatus {
    /// The simulated motion ends within the tolerance, with inputs within their ranges.
    Reached,
    /// There is a motion, but it ends elsewhere or leaves the ranges: a first guess for optimal control.
    FirstGuess,
    /// There is none.
    NotFound,
}

/// How the inputs were made.
#[derive(Clone, Debug)]
pub enum Plan {
    /// In the chained form.
    Chained {
        /// z1 … zn of each leg; more than one leg where no form is regular at both ends.
        coordinates: Vec<Vec<Function>>,
        /// States between the legs.
        way_points: Vec<Vec<f64>>,
    },
    /// By Philip Hall coordinates.
    Nilpotent {
        /// Longest brackets used.
        degree: usize,
        /// Whether all longer brackets vanish, so that one round is exact.
        is_nilpotent: bool,
        /// Rounds, each toward the end from where the one before it ended.
        rounds: usize,
        /// Pieces of constant input.
        pieces: usize,
    },
    /// By flat outputs.
    Flat {
        /// The outputs.
        outputs: Vec<Function>,
        /// Integrators in front of inputs, together.
        integrators: usize,
        /// Degree of the polynomials.
        degrees: Vec<usize>,
    },
    /// By loops of the inputs from rest to rest.
    Loops {
        /// Loops, one after the other.
        loops: usize,
        /// Different loops among them.
        shapes: usize,
    },
    /// By shooting.
    Shooting {
        /// Sinusoids per input.
        harmonics: usize,
        /// Starts that were tried.
        starts: usize,
    },
}

impl Plan {
    /// The method.
    pub fn method(&self) -> SteerMethod {
        match self {
            Plan::Chained { .. } => SteerMethod::Chained,
            Plan::Nilpotent { .. } => SteerMethod::Nilpotent,
            Plan::Flat { .. } => SteerMethod::Flat,
            Plan::Loops { .. } => SteerMethod::Loops,
            Plan::Shooting { .. } => SteerMethod::Shooting,
        }
    }
}

/// Why a method did not reach the end.
#[derive(Clone, Debug, PartialEq)]
pub enum SteerReason {
    /// The method is for models that rest without inputs.
    Drift,
    /// The equations are not affine in the inputs.
    NotAffine,
    /// The equations switch (dry friction, absolute values).
    Switches,
    /// Inputs that act later than they are commanded.
    Delays,
    /// No chained form.
    NoChainedForm(NoChainedForm),
    /// No chained form was found that is regular along a path between the states.
    Singular,
    /// The brackets up to a length span too little at a generic point.
    Brackets {
        /// Dimension of their span.
        dimension: usize,
        /// Number of states.
        states: usize,
        /// Longest brackets that were formed.
        degree: usize,
    },
    /// No flat outputs were found, as many as inputs.
    NoFlatOutputs,
    /// An input would have to take values of a sign that its range does not allow.
    OneSided {
        /// The input.
        input: String,
    },
    /// Loops need states at rest at both ends: velocities zero, inputs and their derivatives the same.
    NotAtRest,
    /// Friction holds a coordinate for all admissible inputs.
    Held {
        /// The coordinate.
        coordinate: String,
    },
    /// The bounds do not fit the model.
    Bounds(FromRestError),
    /// There are no loops for this model, or they do not positively span the coordinates.
    FromRest(FromRestReason),
    /// The loops take longer than asked for.
    TooLong {
        /// Seconds that are needed.
        needed: f64,
    },
    /// Inputs leave their ranges.
    Ranges,
    /// The best motion ends too far away.
    EndError {
        /// Largest difference of a state.
        error: f64,
    },
    /// An exact test did not decide.
    Undecided(Undecided),
    /// The time limit was reached, or it was asked to stop.
    Stopped,
}

/// A method that did not reach the end.
#[derive(Clone, Debug, PartialEq)]
pub struct Attempt {
    /// The method.
    pub method: SteerMethod,
    /// Why not.
    pub reason: SteerReason,
}

/// What is worth knowing of a motion.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum SteerNote {
    /// It takes longer than asked for, so that the inputs stay within their ranges.
    Longer {
        /// Seconds asked for.
        asked: f64,
    },
    /// An input leaves its range.
    OutOfRange {
        /// The input.
        input: String,
    },
}

/// Inputs from one state to another, with the motion that they give.
#[derive(Clone, Debug)]
pub struct Steering {
    /// The model that was steered: the given one, with integrators in front of inputs whose derivatives it uses.
    pub system: System,
    /// How far it went.
    pub status: SteerStatus,
    /// How the inputs were made; `None` if there are none.
    pub plan: Option<Plan>,
    /// Initial state.
    pub from: Vec<f64>,
    /// State that was asked for at the end.
    pub to: Vec<f64>,
    /// The inputs; `None` if none were found.
    pub signals: Option<Signals>,
    /// The motion of the model under these inputs.
    pub motion: Option<Simulation>,
    /// Largest difference of a state from `to` at the end of the motion; infinite without one.
    pub end_error: f64,
    /// Newton steps on the inputs that removed what sampling and the method left of the end error.
    pub corrections: usize,
    /// Methods that did not reach the end.
    pub attempts: Vec<Attempt>,
    /// Notes.
    pub notes: Vec<SteerNote>,
}

impl Steering {
    /// The method of the inputs.
    pub fn method(&self) -> Option<SteerMethod> {
        self.plan.as_ref().map(Plan::method)
    }
}
