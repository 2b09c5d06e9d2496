//! The verdicts by cases of parameters as data.

use std::time::Duration;

use bracketry_symbolic::Function;
use serde::Serialize;

use crate::answer::Answer;
use crate::error::Error;
use crate::evidence::Evidence;
use crate::options::TIME_LIMIT;
use crate::parameters::aspect::{Aspect, AspectValue, NotLinear};
use crate::parameters::confirm::Confirmed;

/// What is asked of [`parameter_cases`](crate::parameter_cases).
#[derive(Clone, Debug)]
pub struct ParameterOptions {
    /// Names of the parameters without fixed value; none for all of the model.
    pub parameters: Vec<String>,
    /// Most simultaneous conditions of a case.
    pub conditions: usize,
    /// Wall-clock time after which the list ends.
    pub time_limit: Option<Duration>,
}

impl Default for ParameterOptions {
    fn default() -> Self {
        ParameterOptions { parameters: Vec::new(), conditions: 2, time_limit: Some(TIME_LIMIT) }
    }
}

/// Values of parameters for which the verdict differs from that for generic values.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterCase {
    /// Functions of the parameters that vanish together; each in the parameters that are left once those before are solved.
    pub conditions: Vec<Function>,
    /// The parameters that the conditions give, by the others.
    pub solved: Vec<(String, Function)>,
    /// The verdict for generic values among them.
    pub value: AspectValue,
    /// Values of the parameters, chosen at random, at which the analysis gave the same verdict; none where the conditions
    /// have no rational solution at hand.
    #[serde(skip_serializing_if = "Confirmed::is_none")]
    pub confirmed_at: Confirmed,
    /// Whether the conditions can hold within the limits that the model gives its parameters; none where that was not
    /// decided.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within_limits: Option<bool>,
}

/// Why cases may be missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Incomplete {
    /// A function of states or parameters that is not covered by exact minors.
    Function {
        /// The function.
        function: Function,
    },
    /// Minors or their factors are too large.
    TooLarge,
    /// Conditions that are not linear in any parameter.
    Nonlinear {
        /// What vanishes.
        condition: Function,
    },
    /// More simultaneous conditions than were asked for may change the verdict again.
    MoreConditions,
    /// The verdict on a set of parameters was not decided.
    Undecided {
        /// Why.
        reason: String,
    },
    /// The time limit, or the memory limit.
    Time,
}

/// One aspect by cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AspectCases {
    /// What is decided.
    pub aspect: Aspect,
    /// The verdict for generic values.
    pub generic: Answer<AspectValue>,
    /// Where it differs.
    pub cases: Vec<ParameterCase>,
    /// Whether the cases are all there are, for real values of the parameters at which the equations are defined.
    pub complete: bool,
    /// Whether they are all that take at most as many simultaneous conditions as were asked for.
    pub complete_up_to_conditions: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub open: Vec<Incomplete>,
}

/// All verdicts by cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterReport {
    /// Name of the model.
    pub model: String,
    /// Number of states.
    pub states: usize,
    /// Parameters without fixed value.
    pub parameters: Vec<String>,
    /// The other parameters, at their values.
    pub fixed: Vec<(String, String)>,
    /// Most simultaneous conditions.
    pub conditions: usize,
    /// Functions of the parameters at whose zeros the equations have no value.
    pub undefined: Vec<Function>,
    /// By aspect.
    pub aspects: Vec<AspectCases>,
    /// Why nothing is said about the linearization.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_linearization: Option<NotLinear>,
    /// What the exact decisions rest on.
    pub certificate: Evidence,
    /// Seconds that it took.
    #[serde(skip)]
    pub seconds: f64,
}

impl ParameterReport {
    /// Whether each list holds all cases with up to the number of conditions that was asked for.
    pub fn is_complete(&self) -> bool {
        self.aspects.iter().all(|a| a.complete_up_to_conditions)
    }
}

/// Why there are no cases at all.
#[derive(Debug, thiserror::Error)]
pub enum ParameterError {
    /// There is nothing to vary.
    #[error("the model has no parameters: give it a table [parameters] with values")]
    NoParameters,
    /// A name that is no parameter.
    #[error("the model has no parameter `{name}`{remedy}")]
    Unknown {
        /// The name.
        name: String,
        /// What may have been meant.
        remedy: String,
    },
    /// The equations switch.
    #[error("the equations switch where {name} = 0: cases of parameters need smooth equations")]
    Switches {
        /// A switching function.
        name: String,
    },
    /// A range of a map.
    #[error("`{text}` is not a map: write two parameters with their ranges, such as a=0..2,b=-1..1")]
    Map {
        /// The text.
        text: String,
    },
    /// Not affine, or no states.
    #[error(transparent)]
    Lie(#[from] Error),
}
