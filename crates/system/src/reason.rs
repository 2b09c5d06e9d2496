//! Why a candidate for an affine form is possible, and why one is rejected.

use std::fmt;

use bracketry_symbolic::{Function, Undecided};
use serde::{Serialize, Serializer};

use crate::new_state::NewState;
use crate::range::Range;
use crate::readable::counted;
use crate::unknown_range::UnknownRange;

/// What is said for a candidate.
#[derive(Clone, Debug, PartialEq)]
pub enum AffineReason {
    /// The right-hand side is affine in the inputs as it stands.
    Affine,
    /// The equations depend on the inputs through independent functions.
    NewInputs {
        /// How many functions.
        functions: usize,
        /// Those that are no old input: name, function, and values.
        changed: Vec<(String, Function, Range)>,
    },
    /// The equations use derivatives of inputs alone, which become inputs.
    LoneDerivatives {
        /// Their names.
        derivatives: Vec<String>,
    },
    /// The inputs enter affinely after integrators.
    Integrators {
        /// What makes integrators necessary.
        causes: Vec<Nonlinearity>,
        /// Number of integrators.
        total: u32,
        /// The new inputs.
        inputs: Vec<String>,
    },
    /// The same with integrators in front of some inputs.
    After {
        /// These inputs.
        integrators: Vec<String>,
        /// What holds then.
        then: Box<AffineReason>,
    },
    /// New states save integrators.
    NewStates {
        /// The new states.
        states: Vec<NewState>,
        /// Integrators that are left.
        integrators: usize,
        /// Integrators without the new states.
        instead_of: usize,
    },
    /// The affine system lacks delays.
    WithoutDelays {
        /// Functions of inputs after their delays.
        functions: Vec<String>,
        /// What holds besides.
        then: Box<AffineReason>,
    },
    /// The candidate is rejected.
    Rejected(Rejection),
}

/// What asks for integrators in front of an input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Nonlinearity {
    /// A derivative of the input enters.
    Derivative {
        /// The input.
        input: String,
        /// Order of the highest derivative.
        order: u32,
    },
    /// The input enters nonlinearly.
    Nonlinear {
        /// The input.
        input: String,
    },
    /// The input multiplies others.
    Products {
        /// The input.
        input: String,
        /// The others.
        with: Vec<String>,
    },
}

/// More inputs that multiply each other are not searched.
pub(crate) const MAX_INPUTS: usize = 16;

/// Why no affine form was given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AffineError {
    /// An exact test came out undecided.
    #[error("whether the equations are affine in the inputs is undecided: {0}")]
    Undecided(#[from] Undecided),
    /// More inputs multiply each other than the search over subsets takes.
    #[error(
        "{inputs} inputs multiply each other, too many for the search over integrators (at most {MAX_INPUTS}): write some of \
         them as states with a new input each"
    )]
    TooManyInputs {
        /// Number of such inputs.
        inputs: usize,
    },
}

/// Why a candidate is rejected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Rejection {
    /// An exact test is undecided.
    #[error("undecided: {0}")]
    Undecided(#[from] Undecided),
    /// The system with new states is not made affine.
    #[error(transparent)]
    Affine(#[from] AffineError),
    /// More independent functions than inputs.
    #[error(
        "the equations depend on the inputs through {functions} independent functions, more than there are inputs ({inputs})"
    )]
    TooMany {
        /// Number of functions.
        functions: usize,
        /// Number of inputs.
        inputs: usize,
    },
    /// The functions of the inputs depend on each other.
    #[error(
        "the equations depend on the inputs through {}; only {independent} of them can be chosen freely",
        counted(*functions, "function", "functions")
    )]
    Dependent {
        /// Number of functions.
        functions: usize,
        /// Generic rank of their Jacobian.
        independent: usize,
    },
    /// The equations with the functions put back are not the original ones.
    #[error("substituting the functions back does not restore the equations")]
    NotRestored,
    /// A function switches, and its values are not known.
    #[error("the function {} switches, and {reason}", function.text())]
    Switches {
        /// The function.
        function: Function,
        /// Why its values are not known.
        reason: UnknownRange,
    },
    /// An equation does not separate.
    #[error("{} is not a sum of products of a function of the states and a function of the inputs", .0.text())]
    Mixed(Function),
    /// An input changes the sign of a switching function.
    #[error("a switching function depends on an input")]
    SwitchOfInput,
    /// None, or too many functions to solve for.
    #[error("the equations were not solved for {functions} functions of the inputs")]
    Unsolved {
        /// Their number.
        functions: usize,
    },
    /// No value of the inputs at which the Jacobian is regular was found.
    #[error("no simple value of the inputs was found at which the equations can be solved for the functions")]
    NoRegularValue,
    /// The span of ∂f/∂u depends on the inputs.
    #[error(
        "the inputs move the velocities in {} at a time, but these directions depend on the inputs",
        counted(*directions, "direction", "directions")
    )]
    DirectionsVary {
        /// Dimension of the span.
        directions: usize,
    },
    /// A derivative of an input stays in the equations of the new states.
    #[error("{derivative} does not cancel")]
    Remains {
        /// The derivative.
        derivative: String,
    },
    /// The inverse of the new states does not restore the equations.
    #[error("transforming back does not restore the equations")]
    NotInverted,
    /// An output depends on the derivative.
    #[error("an output depends on {derivative}")]
    OutputDepends {
        /// The derivative.
        derivative: String,
    },
    /// A switching function depends on the derivative.
    #[error("a switching function depends on {derivative}")]
    SwitchDepends {
        /// The derivative.
        derivative: String,
    },
    /// The coefficient of the derivative jumps.
    #[error("the coefficient of {derivative} jumps with the sign of a switching function")]
    CoefficientJumps {
        /// The derivative.
        derivative: String,
    },
    /// The derivative enters nonlinearly.
    #[error("{derivative} enters nonlinearly")]
    Nonlinear {
        /// The derivative.
        derivative: String,
    },
    /// The coefficient of the derivative depends on what is neither state, parameter, nor a lower derivative.
    #[error("the coefficient of {derivative} depends on {on}")]
    CoefficientDepends {
        /// The derivative.
        derivative: String,
        /// What its coefficient depends on.
        on: String,
    },
    /// The flow that gives the new states is not known in closed form.
    #[error("the states that are free of {derivative} were not found in closed form")]
    NoClosedForm {
        /// The derivative.
        derivative: String,
    },
    /// New states save no integrator.
    #[error(
        "with {} replacing {}, the inputs still need {}",
        definitions(states),
        replaced(states),
        counted(*integrators, "integrator", "integrators")
    )]
    NoFewerIntegrators {
        /// The new states.
        states: Vec<NewState>,
        /// Integrators that are left.
        integrators: usize,
    },
}

impl fmt::Display for Nonlinearity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Nonlinearity::Derivative { input, order } => {
                write!(f, "{input} enters with derivatives up to order {order}")
            }
            Nonlinearity::Nonlinear { input } => write!(f, "{input} enters nonlinearly"),
            Nonlinearity::Products { input, with } => write!(f, "{input} multiplies {}", with.join(", ")),
        }
    }
}

impl fmt::Display for AffineReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AffineReason::Affine => f.write_str("the right-hand side is already affine in the inputs"),
            AffineReason::NewInputs { functions, changed } => {
                let shown = changed.iter().map(|(name, function, values)| {
                    let limits = values.text(name).map_or(String::new(), |l| format!(" ({l})"));
                    format!("{name} = {}{limits}", function.text())
                });
                write!(
                    f,
                    "the equations depend on the inputs through {}: {}",
                    counted(*functions, "independent function", "independent functions"),
                    shown.collect::<Vec<_>>().join(", ")
                )
            }
            AffineReason::LoneDerivatives { derivatives } => write!(
                f,
                "the equations use {} only, which can itself serve as an input; its antiderivative is dropped",
                derivatives.join(", ")
            ),
            AffineReason::Integrators { causes, total, inputs } => write!(
                f,
                "{}; with {}, {} affinely{}",
                causes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "),
                counted(*total as usize, "integrator", "integrators"),
                if let [input] = &inputs[..] {
                    format!("the input {input} enters")
                } else {
                    format!("the inputs {} enter", inputs.join(" and "))
                },
                if *total > 1 { ", and fewer integrators alone do not suffice" } else { "" }
            ),
            AffineReason::After { integrators, then } => {
                write!(f, "with integrators in front of {}, {then}", integrators.join(", "))
            }
            AffineReason::NewStates { states, integrators, instead_of } => write!(
                f,
                "with the states {}, the inputs need {} instead of {instead_of}",
                definitions(states),
                counted(*integrators, "integrator", "integrators")
            ),
            AffineReason::WithoutDelays { functions, then } => write!(
                f,
                "{then}; functions of inputs after their delays, which the affine system does not have, are {}",
                functions.join(", ")
            ),
            AffineReason::Rejected(why) => write!(f, "{why}"),
        }
    }
}

impl Serialize for AffineReason {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn definitions(states: &[NewState]) -> String {
    states.iter().map(|z| format!("{} = {}", z.name, z.function.text())).collect::<Vec<_>>().join(", ")
}

fn replaced(states: &[NewState]) -> String {
    states.iter().map(|z| z.replaces.as_str()).collect::<Vec<_>>().join(", ")
}
