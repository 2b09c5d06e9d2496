//! What verdicts on zero dynamics and flatness rest on.

use bracketry_symbolic::Function;

use crate::as_text::serialized_as_text;
use crate::reason::open::Reason;
use crate::reason::text::texts;
use crate::undecided::Undecided;

/// What a verdict on the zero dynamics rests on, or why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MinimumPhaseReason {
    /// The outputs determine the state.
    #[error("no motion is left")]
    NoMotion,
    /// The divergence vanishes (Liouville).
    #[error("the zero dynamics preserve volume, so no equilibrium attracts")]
    PreservesVolume,
    /// All eigenvalues are in the left half-plane.
    #[error("the eigenvalues of the zero dynamics have negative real parts")]
    Stable,
    /// One eigenvalue is in the right half-plane.
    #[error("the zero dynamics have an eigenvalue with positive real part")]
    Unstable,
    /// The only eigenvalue is negative.
    #[error("the eigenvalue of the zero dynamics is negative")]
    Negative,
    /// The only eigenvalue is positive.
    #[error("the eigenvalue of the zero dynamics is positive")]
    Positive,
    /// z' = 0.
    #[error("every point of the zero dynamics is at rest")]
    AtRest,
    /// z' = c z^k + …
    #[error("the leading term of the zero dynamics is a multiple of {state}^{order}")]
    Order {
        /// The coordinate.
        state: String,
        /// The first power that occurs.
        order: usize,
    },
    /// A Lyapunov function.
    #[error("the Lyapunov function {function} decreases along all motions near the equilibrium (LaSalle)")]
    Lyapunov {
        /// The function.
        function: Function,
    },
    /// The same backwards in time.
    #[error("{function} increases along all motions near the equilibrium, which is unstable")]
    Repels {
        /// The function.
        function: Function,
    },
    /// A first integral.
    #[error("{function} is constant along motions{}", if *.stable {
        " and has a strict extremum at the equilibrium: stable, but not asymptotically"
    } else {
        ", so not all nearby motions approach the equilibrium"
    })]
    Conserved {
        /// The integral.
        function: Function,
        /// Whether its second derivatives are definite, so that the equilibrium is stable.
        stable: bool,
    },
    /// s' = c s^k + … on a center manifold of dimension 1.
    #[error("on the center manifold, the leading term is a {} multiple of the power {order} (Carr 1981)",
        if *.falls { "negative" } else { "positive" })]
    CenterManifold {
        /// k.
        order: usize,
        /// Whether c < 0.
        falls: bool,
    },
    /// V' = l q^((k + 1)/2) + … on a center manifold of dimension 2 with a pair ±iω of eigenvalues.
    #[error("on the center manifold of the oscillating pair, the first focal value, of order {order}, is {} (Lyapunov 1892)",
        if *.falls { "negative" } else { "positive" })]
    FocalValue {
        /// k.
        order: u32,
        /// Whether l < 0.
        falls: bool,
    },
    /// Not decided.
    #[error(transparent)]
    Open(#[from] Reason),
}

/// What a verdict on flatness rests on, or why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlatnessReason {
    /// Flat systems are strongly accessible.
    #[error("not strongly accessible: no input influences some function of the state")]
    NotAccessible,
    /// Flat by static feedback.
    #[error("linearizable by static feedback")]
    StaticFeedback,
    /// With one input, flatness is linearizability by static feedback.
    #[error(
        "a system with one input is flat only if it is linearizable by static feedback (Charlet, Lévine, and Marino 1989)"
    )]
    OneInput,
    /// The velocities that the inputs give do not form a ruled manifold.
    #[error(
        "the set of velocities that the inputs give contains no line, so it is not a ruled manifold (Rouchon 1994, \
         Sluis 1993)"
    )]
    NotRuled,
    /// The new inputs of the affine form are not independent functions of the old ones.
    #[error(
        "the affine form has dependent inputs; its flatness does not decide that of the model, and the model's \
         velocities are not known to exclude flatness"
    )]
    DependentInputs,
    /// m = n − 1.
    #[error("strongly accessible, with one fewer input than states (Charlet, Lévine, and Marino 1989)")]
    OneInputLess,
    /// m = n − 2 without drift.
    #[error("accessible without drift, with two fewer inputs than states (Martin and Rouchon 1995)")]
    TwoInputsLess,
    /// Outputs of the model with which the dynamic extension algorithm ends.
    #[error("dynamic feedback linearizes the system by the outputs of the model")]
    ModelOutputs,
    /// Other functions with which it does.
    #[error("dynamic feedback linearizes the system by these functions")]
    Functions,
    /// Two inputs without drift: the derived flag decides.
    #[error("the derived flag of the two inputs has dimensions {}{} (Martin and Rouchon 1994)", texts(.dimensions),
        .expected.map_or(String::new(), |n| format!(", which do not grow by one up to {n}")))]
    DerivedFlag {
        /// Dimensions of the derived flag.
        dimensions: Vec<usize>,
        /// The number of states, where the dimensions do not grow by one up to it.
        expected: Option<usize>,
    },
    /// Integrators in front of one input.
    #[error("linearizable by static feedback after {} in front of {input}",
        if *.integrators == 1 { "an integrator".to_owned() } else { format!("{} integrators", .integrators) })]
    Prolongation {
        /// How many.
        integrators: usize,
        /// The input.
        input: String,
    },
    /// No criterion applies.
    #[error("no flat outputs were found among the functions tried, and no criterion excludes them")]
    NotFound,
    /// An exact test cannot tell.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

serialized_as_text!(MinimumPhaseReason, FlatnessReason);
