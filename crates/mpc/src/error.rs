//! What can be wrong with a problem before anything is solved.

use bracketry_symbolic::{CompileError, StopFlag};

/// Why a plant could not be simulated further.
pub type PlantFailure = Box<dyn std::error::Error + Send + Sync>;

/// Misuse or bad input; outcomes of a solution process are statuses instead.
#[derive(Debug, thiserror::Error)]
pub enum MpcError {
    /// A vector does not have the length the problem asks for.
    #[error("{what} has length {found}, expected {expected}")]
    Length {
        /// The vector.
        what: &'static str,
        /// Length given.
        found: usize,
        /// Length needed.
        expected: usize,
    },
    /// A number is not finite or outside its range.
    #[error("{what} is {value}: {remedy}")]
    Value {
        /// The quantity.
        what: String,
        /// Its value.
        value: f64,
        /// What to do about it.
        remedy: &'static str,
    },
    /// A measurement comes at a time at which none can be used.
    #[error("the measurement at t = {time:?} cannot be used: {reason}")]
    Time {
        /// Its time, s.
        time: f64,
        /// Why, and what to do about it.
        reason: &'static str,
    },
    /// A lower bound lies above its upper bound.
    #[error("the bounds of {what} {} contradict each other: min {min} > max {max}", named(name.as_deref(), *index))]
    EmptyBounds {
        /// `"state"`, `"input"`, or `"path constraint"`.
        what: &'static str,
        /// Its index, from 0.
        index: usize,
        /// Its name, where it is known.
        name: Option<String>,
        /// Lower bound.
        min: f64,
        /// Upper bound.
        max: f64,
    },
    /// An index names no state.
    #[error("there is no state with index {index}: the model has {states}")]
    NoSuchState {
        /// The index, from 0.
        index: usize,
        /// Number of states.
        states: usize,
    },
    /// Measured outputs do not tell of everything that is to be estimated.
    #[error("the measured outputs do not determine {} separately: measure more or estimate less", names.join(", "))]
    NotObservable {
        /// What cannot be told.
        names: Vec<String>,
    },
    /// The problem cannot be stated with the values that were found for what it leaves free.
    #[error("with the free values that were found: {reason}")]
    ValuesFound {
        /// Why not.
        reason: String,
    },
    /// A name is not known.
    #[error("there is no {what} `{name}`: {}", known_names(known))]
    NoSuchName {
        /// What was looked for: `"parameter"`, `"input"`, `"state"`.
        what: &'static str,
        /// The name.
        name: String,
        /// The names that would do.
        known: Vec<String>,
    },
    /// The inputs cannot bring every state to rest.
    #[error("the linearized system is not stabilizable: add an input, or remove the states that no input reaches")]
    NotStabilizable,
    /// A motion that does not decay costs nothing.
    #[error("an undamped motion has no cost: give a cost to every state that does not decay by itself")]
    NotDetectable,
    /// A point is not at rest.
    #[error(
        "the point is not a steady state: state {} moves by {moved} over one interval; give a state and input at rest",
        named(name.as_deref(), *index)
    )]
    NotSteady {
        /// Index of the state, from 0.
        index: usize,
        /// Its name, where it is known.
        name: Option<String>,
        /// Its movement over one interval.
        moved: f64,
    },
    /// The references do not determine the steady state.
    #[error(
        "the references do not determine the steady state: give a cost to every state, or set the terminal cost \
         explicitly"
    )]
    SteadyStateNotUnique,
    /// There is no stage cost to be continued beyond the horizon.
    #[error("there is no stage cost: set `Ocp::stage` first")]
    NoStageCost,
    /// Second derivatives were asked for where there are none.
    #[error("the dynamics have no second derivatives: use symbolic dynamics, or the Gauss-Newton Hessian")]
    NoSecondDerivatives,
    /// The plant could not be simulated further.
    #[error("the plant stopped at t = {time}: {source}")]
    Plant {
        /// Time of the sample, s.
        time: f64,
        /// The reason.
        source: PlantFailure,
    },
    /// A name that should be a parameter of the model is none.
    #[error("the model has no parameter `{name}`: it has {}", if known.is_empty() { "none".into() } else { known.join(", ") })]
    NoSuchParameter {
        /// The name.
        name: String,
        /// The model's parameters.
        known: Vec<String>,
    },
    /// The equations use a derivative of an input.
    #[error("the equations use {name}: make the model affine first, so that this derivative becomes an input")]
    InputDerivative {
        /// The derivative.
        name: String,
    },
    /// The problem says nothing of a run.
    #[error(
        "[run] is missing, so the loop has no start: add run = {{ x0 = {{ … }}, steps = 100 }}; only a live \
         controller (--live) works without it"
    )]
    NoRun,
    /// The flag of the settings was raised.
    #[error("the computation was stopped")]
    Stopped,
    /// A cost cannot be read.
    #[error(transparent)]
    Parse(#[from] bracketry_symbolic::ParseError),
    /// An expression uses a name that is neither a state, an input, the time nor a reference.
    #[error(transparent)]
    Compile(#[from] CompileError),
}

impl MpcError {
    /// With the names of states and inputs of a model.
    pub(crate) fn with_names(mut self, states: &[String], inputs: &[String]) -> Self {
        let found = match &mut self {
            Self::EmptyBounds { what: "state", index, name, .. } | Self::NotSteady { index, name, .. } => {
                Some((name, states.get(*index)))
            }
            Self::EmptyBounds { what: "input", index, name, .. } => Some((name, inputs.get(*index))),
            _ => None,
        };
        if let Some((name, Some(found))) = found {
            *name = Some(found.clone());
        }
        self
    }
}

/// A name in quotes, or the index.
fn named(name: Option<&str>, index: usize) -> String {
    name.map_or_else(|| index.to_string(), |name| format!("`{name}`"))
}

/// [`MpcError::Stopped`] once the flag is raised.
pub(crate) fn check_flag(stop: &StopFlag) -> Result<(), MpcError> {
    if stop.is_raised() { Err(MpcError::Stopped) } else { Ok(()) }
}

fn known_names(known: &[String]) -> String {
    if known.is_empty() { "the problem has none".to_owned() } else { format!("the problem has {}", known.join(", ")) }
}

/// [`MpcError::Value`] unless the value is good.
pub(crate) fn check_value(
    good: bool,
    what: impl Into<String>,
    value: f64,
    remedy: &'static str,
) -> Result<(), MpcError> {
    if good { Ok(()) } else { Err(MpcError::Value { what: what.into(), value, remedy }) }
}

pub(crate) fn check_length(what: &'static str, found: usize, expected: usize) -> Result<(), MpcError> {
    if found == expected { Ok(()) } else { Err(MpcError::Length { what, found, expected }) }
}
