//! What is asked for, and what is wrong with it.

use bracketry_mpc::MpcError;
use bracketry_sim::{InputError, SimError};
use bracketry_symbolic::StopFlag;
use std::time::Duration;

/// The least and the greatest value of an input, of its rate `der(u)`, or of a state.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// `u`, `der(u)`, or the name of a state.
    pub name: String,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

impl Limit {
    /// The interval from `low` to `high`.
    pub fn new(name: &str, low: f64, high: f64) -> Self {
        Self { name: name.to_owned(), low, high }
    }
}

/// What an experiment may do, and what is measured in it.
#[derive(Clone, Debug)]
pub struct ExperimentOptions {
    /// Length of the experiment, s.
    pub duration: f64,
    /// Time between two measurements, s; a two-hundredth of the duration where it is not given.
    pub sample: Option<f64>,
    /// Limits of inputs, of their rates, and of states. An input that is not named keeps the range of its model.
    pub limits: Vec<Limit>,
    /// What is measured: outputs or states by name; where it is empty, the outputs of the models, or else their states.
    pub measured: Vec<String>,
    /// Standard deviation of the noise of measured columns, by name.
    pub noise: Vec<(String, f64)>,
    /// Parameters that are known: no refit changes them.
    pub fixed: Vec<String>,
    /// Number of inputs from which the optimization starts.
    pub starts: usize,
    /// Seed of random starts.
    pub seed: u64,
    /// No optimization is started after six tenths of this time.
    pub time_limit: Option<Duration>,
    /// Once it is raised, the work ends.
    pub stop: StopFlag,
}

impl ExperimentOptions {
    /// An experiment of `duration` seconds within the ranges of the model.
    pub fn lasting(duration: f64) -> Self {
        Self {
            duration,
            sample: None,
            limits: Vec::new(),
            measured: Vec::new(),
            noise: Vec::new(),
            fixed: Vec::new(),
            starts: 6,
            seed: 1,
            time_limit: None,
            stop: StopFlag::default(),
        }
    }
}

/// An experiment that cannot be designed, with the remedy.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// A name that the models do not have.
    #[error("{option} names `{name}`, which is not {what}\n   = {remedy}")]
    UnknownName {
        /// Where it stands.
        option: &'static str,
        /// The name.
        name: String,
        /// What it should be.
        what: &'static str,
        /// What to write instead.
        remedy: String,
    },
    /// An input without limits.
    #[error(
        "the input `{input}` has no limits, and without any the best experiment is infinitely strong\n   = add --limits \
         {input}=LOW..HIGH, or `{input} = {{ min, max }}` under [ranges] of the model"
    )]
    NoLimits {
        /// The input.
        input: String,
    },
    /// The start lies outside a limit.
    #[error(
        "`{name}` starts at {value}, outside its limits {low}..{high}\n   = widen the limits, or change [point] of the model"
    )]
    StartOutside {
        /// The state or input.
        name: String,
        /// Its value at the start.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
    /// A limit or number that is none.
    #[error("{what} is {value}: {remedy}")]
    Value {
        /// What it is.
        what: String,
        /// Its value.
        value: f64,
        /// What to give.
        remedy: &'static str,
    },
    /// A model without inputs.
    #[error(
        "the model has no inputs: nothing can be chosen\n   = declare what can be chosen with `inputs` in the model"
    )]
    NoInputs,
    /// Two models of different inputs.
    #[error("the explanations have different inputs, {} and {}\n   = both must be models of one system: use the same names", .a.join(", "), .b.join(", "))]
    DifferentInputs {
        /// Inputs of the first.
        a: Vec<String>,
        /// Inputs of the second.
        b: Vec<String>,
    },
    /// Two models of different measurements.
    #[error(
        "`{column}` is measured in one explanation, and the other one has neither an output nor a state of that name\n   = \
         both must be models of one system: use the same names under [outputs]"
    )]
    DifferentColumns {
        /// The column.
        column: String,
    },
    /// Nothing is measured in both models.
    #[error(
        "the explanations have no measured column in common\n   = use the same names under [outputs] of both models"
    )]
    NoColumns,
    /// The equations use derivatives of an input.
    #[error(
        "{model}: the equations use derivatives of `{input}`\n   = `bracketry affinize MODEL --out DIR` writes the model with \
         integrators in front of it"
    )]
    Derivatives {
        /// Name of the model.
        model: String,
        /// The input.
        input: String,
    },
    /// A model that calls something else `t`.
    #[error("{model}: the model calls a {kind} `t`, which is time here\n   = rename the {kind} in the model")]
    Time {
        /// Name of the model.
        model: String,
        /// What it calls so.
        kind: &'static str,
    },
    /// A model of a kind that cannot be planned with.
    #[error("{model}: {what} cannot be planned with\n   = write the model as x' = f(x, u)")]
    Kind {
        /// Name of the model.
        model: String,
        /// What it has.
        what: &'static str,
    },
    /// The model cannot be simulated, even under the simplest inputs.
    #[error(
        "{model}: the simulation stops under every input that was tried\n   = try a shorter duration or narrower limits"
    )]
    Simulation {
        /// Name of the model.
        model: String,
    },
    /// The equations cannot be used.
    #[error(transparent)]
    Mpc(#[from] MpcError),
    /// Inputs that do not fit.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A simulation that cannot be set up.
    #[error(transparent)]
    Sim(#[from] SimError),
}
