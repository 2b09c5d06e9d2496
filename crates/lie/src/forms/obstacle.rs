//! Why a form does not exist, or was not found.

use bracketry_symbolic::Function;

use crate::as_text::serialized_as_text;
use crate::error::Error;
use crate::reason::FlatnessReason;
use crate::undecided::Undecided;

/// What stands in the way of a form. Whether it excludes the form or only the search for it is said by
/// [`FormOutcome`](crate::forms::FormOutcome).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Obstacle {
    /// The equations are not affine in the inputs.
    #[error("{equation} is not affine in the inputs")]
    NotAffine {
        /// Where.
        equation: String,
    },
    /// The equations switch.
    #[error("the equations have {modes} modes, and a change of coordinates needs smooth ones")]
    Switches {
        /// Number of modes.
        modes: usize,
    },
    /// There is nothing to act with.
    #[error("the model has no inputs")]
    NoInputs,
    /// There is nothing to transform by.
    #[error("the model has no outputs")]
    NoOutputs,
    /// An input acts later than it is commanded.
    #[error("the input {input} acts with a delay, so feedback cannot cancel terms at once")]
    Delay {
        /// The input.
        input: String,
    },
    /// An output depends on an input directly.
    #[error("an output depends on an input directly: its relative degree is 0")]
    FedThrough,
    /// The fields of the inputs are dependent.
    #[error("the fields of the {inputs} inputs span {rank} dimensions: some inputs are redundant")]
    DependentInputs {
        /// Their number.
        inputs: usize,
        /// Rank of their fields.
        rank: usize,
    },
    /// `D_i = span{ad_f^k g_j, k ≤ i}` is not involutive (Jakubczyk and Respondek; Hunt, Su, and Meyer).
    #[error("the distribution D_{index} = span{{ad_f^k g_j, k ≤ {index}}} is not involutive")]
    NotInvolutive {
        /// i.
        index: usize,
    },
    /// The distributions D_i end below the dimension of the state.
    #[error("the distributions D_i end at dimension {dimension} of {states}: the inputs do not reach all of the state")]
    NotReached {
        /// Dimension at which they end.
        dimension: usize,
        /// Number of states.
        states: usize,
    },
    /// Linearizing outputs exist but have no closed form here.
    #[error("the condition holds, but no linearizing outputs were found in closed form")]
    NoLinearizingOutputs,
    /// There are more or fewer outputs than inputs.
    #[error("{outputs} outputs are selected for {inputs} inputs: the form needs as many outputs as inputs")]
    NotSquare {
        /// Number of outputs.
        outputs: usize,
        /// Number of inputs.
        inputs: usize,
    },
    /// The form is of one output.
    #[error("{outputs} outputs are selected: the form needs one")]
    NotSingle {
        /// Number of outputs.
        outputs: usize,
    },
    /// No input ever reaches an output.
    #[error("no input ever reaches the output {output}")]
    Unreached {
        /// The output.
        output: String,
    },
    /// The decoupling matrix is singular everywhere.
    #[error("the decoupling matrix has rank {rank} of {outputs} everywhere: there is no vector relative degree")]
    NoRelativeDegree {
        /// Its rank.
        rank: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// Functions that complete coordinates were not found.
    #[error("{missing} of the new coordinates were not found in closed form")]
    CoordinatesNotFound {
        /// How many.
        missing: usize,
    },
    /// T was found, but its inverse has no closed form here.
    #[error("the coordinates are known, but the old states were not found as functions of them in closed form")]
    NoInverse {
        /// T.
        coordinates: Vec<Function>,
    },
    /// The result could not be confirmed by transforming back.
    #[error("transforming back could not be confirmed for {name}")]
    Unconfirmed {
        /// State or output.
        name: String,
    },
    /// The output with its derivatives along the drift does not tell the state.
    #[error("the output with its derivatives along the drift gives {rank} of {states} independent functions")]
    NotObservable {
        /// How many.
        rank: usize,
        /// Number of states.
        states: usize,
    },
    /// The equation of the output is not linear up to functions of it (Krener and Isidori; Krener and Respondek).
    #[error(
        "in the differential equation of the output, the coefficient of the derivative of order {order} is not a \
         function of the output alone, for any choice of a new output"
    )]
    OutputInjection {
        /// Which.
        order: usize,
    },
    /// An input enters with a factor that is no function of the output.
    #[error(
        "the coefficient of the input {input} in the equation of coordinate {coordinate} is not a function of the \
         output alone"
    )]
    InputInjection {
        /// The input.
        input: String,
        /// The coordinate, from 1.
        coordinate: usize,
    },
    /// A function that exists has no closed form here.
    #[error("{function} was not integrated or written as a function of the output in closed form")]
    NoClosedForm {
        /// Which.
        function: Function,
    },
    /// The chained form is one of two inputs.
    #[error("the chained form has two independent inputs: the model has {independent}")]
    NotTwoInputs {
        /// Independent input fields.
        independent: usize,
    },
    /// The equations do not vanish with the inputs.
    #[error("the equations do not vanish with the inputs, but the chained form has no drift")]
    Drift,
    /// The derived flag does not grow by one.
    #[error("the derived flag of the two inputs has dimensions {}, not 2, 3, … up to the number of states", listed(.dimensions))]
    DerivedFlag {
        /// Its dimensions at a generic point.
        dimensions: Vec<usize>,
    },
    /// The system is not flat.
    #[error("not flat: {reason}")]
    NotFlat {
        /// Why.
        reason: FlatnessReason,
    },
    /// Whether the system is flat is open.
    #[error("flatness is undecided: {reason}")]
    FlatnessOpen {
        /// Why.
        reason: FlatnessReason,
    },
    /// The system is flat, but flat outputs were not found.
    #[error("the system is flat ({reason}), but flat outputs were not found in closed form")]
    NoFlatOutputs {
        /// What the verdict rests on.
        reason: FlatnessReason,
    },
    /// The decoupling matrix is singular where the outputs are held.
    #[error("the decoupling matrix is singular where the outputs are held")]
    SingularWhereHeld,
    /// The linearization has entries that are no rational numbers.
    #[error("the linearization has entries that are not rational, and ranks are decided in exact arithmetic")]
    Irrational,
    /// The linearization is not defined.
    #[error("there is no linearization at the point: {why}")]
    NotLinearizable {
        /// Why.
        why: String,
    },
    /// The point is no equilibrium.
    #[error("the model is not linear, and its point is not an equilibrium (derivatives up to {residual:.3})")]
    NotAtRest {
        /// Largest derivative.
        residual: f64,
    },
    /// A question stays open.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

fn listed(dimensions: &[usize]) -> String {
    dimensions.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

serialized_as_text!(Obstacle);

/// How a form ends before it is found.
#[derive(Clone, Debug)]
pub(crate) enum Stop {
    /// It does not exist.
    No(Obstacle),
    /// It was not found.
    Unknown(Obstacle),
}

impl From<Undecided> for Stop {
    fn from(why: Undecided) -> Self {
        Stop::Unknown(why.into())
    }
}

impl From<bracketry_symbolic::Undecided> for Stop {
    fn from(why: bracketry_symbolic::Undecided) -> Self {
        Stop::Unknown(Undecided::from(why).into())
    }
}

/// An error of the fields as an obstacle; what is misuse stays an error.
pub(crate) fn of_error(error: Error) -> Result<Stop, Error> {
    match error {
        Error::NotAffine { equation } => Ok(Stop::Unknown(Obstacle::NotAffine { equation })),
        Error::Modes { switches } => Ok(Stop::Unknown(Obstacle::Switches { modes: 1 << switches.min(62) })),
        Error::Undecided(why) => Ok(why.into()),
        other => Err(other),
    }
}
