//! What verdicts on small-time local controllability rest on.

use std::fmt;

use bracketry_symbolic::{Function, Rational};

use crate::algebra::word::Bracket;
use crate::as_text::serialized_as_text;
use crate::reason::open::Reason;
use crate::reason::text::{equations, integrals, texts};
use crate::undecided::Undecided;

/// What a verdict on small-time local controllability rests on, or why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StlcReason {
    /// Bounded inputs cannot hold the state.
    #[error("the drift does not vanish at the point, and no input balances it")]
    NotBalanced,
    /// Other inputs may hold the state.
    #[error("the point is not an equilibrium for the given inputs")]
    NoEquilibrium,
    /// The orbit is a manifold of lower dimension (Nagano–Sussmann).
    #[error("the accessibility algebra has dimension {dimension} < {states} at the point")]
    NotAccessible {
        /// Dimension of the algebra.
        dimension: usize,
        /// Number of states.
        states: usize,
    },
    /// Kalman's condition.
    #[error("the linearization is controllable")]
    Controllable,
    /// A half-space that no trajectory leaves (Nagumo).
    #[error("from its value at the point, {function} cannot {change} for any inputs{}",
        if *.one_sided { " in their one-sided ranges" } else { "" })]
    HalfSpace {
        /// The linear function that bounds it.
        function: Function,
        /// How the function can not change.
        change: Monotone,
        /// Whether that takes the one-sided ranges of inputs.
        one_sided: bool,
    },
    /// Without the dimension at the point nothing is decided.
    #[error("the accessible dimension is not decided: {0}")]
    DimensionOpen(Reason),
    /// Chow and Rashevskii.
    #[error("no drift and full dimension (Chow–Rashevskii)")]
    NoDrift,
    /// Sussmann's general sufficient condition holds.
    #[error("Sussmann's condition holds with weights {weights:?} of drift and inputs")]
    Sussmann {
        /// Weights of drift and inputs.
        weights: Vec<u32>,
    },
    /// It is obstructed.
    #[error("the bad bracket {bracket} is not neutralized with weights {weights:?}; {further} other choices of \
             weights fail too{}", if *.too_many { ", some because they need too many brackets" } else { "" })]
    Obstructed {
        /// The bad bracket.
        bracket: Bracket,
        /// Weights of drift and inputs.
        weights: Vec<u32>,
        /// Number of other choices of weights.
        further: usize,
        /// Whether some of these took too many brackets.
        too_many: bool,
    },
    /// Its brackets are too many.
    #[error("Sussmann's condition needs too many brackets")]
    TooManyBrackets,
    /// Stefani's necessary condition fails for this even power.
    #[error(
        "ad_g^{0} f at the point is not a combination of brackets with fewer factors g (Stefani's necessary condition)"
    )]
    Stefani(usize),
    /// A definite quadratic form, of brackets of this depth.
    #[error("second-order brackets of {} with f are definite modulo the subspace that the linearization reaches",
        if *.0 == 0 { "the inputs".to_owned() } else { format!("the inputs and their first {} brackets", .0) })]
    DefiniteForm(usize),
    /// A condition holds after a change of the inputs.
    #[error("{reason} for the inputs along {}", texts(.inputs))]
    InputsAlong {
        /// The condition.
        reason: Box<StlcReason>,
        /// The inputs in which it holds.
        inputs: Vec<InputCombination>,
    },
    /// An exact test cannot tell.
    #[error(transparent)]
    Undecided(#[from] Undecided),
    /// One-sided inputs away from an equilibrium.
    #[error("inputs are one-sided, and the point is not an equilibrium")]
    OneSidedNoEquilibrium,
    /// No inputs in their ranges hold the state, by this linear function.
    #[error("the rate of {0} at the point is positive for all inputs in their ranges")]
    Separated(Function),
    /// All inputs push to one side.
    #[error("all inputs that act at the point have one-sided ranges and push in one direction")]
    OneSidedCone,
    /// No condition for one-sided inputs decides.
    #[error("inputs are one-sided; no known condition decides this case")]
    OneSidedOpen,
    /// The other inputs suffice.
    #[error("{0} with the two-sided inputs alone")]
    TwoSidedInputs(Box<StlcReason>),
    /// A condition holds for integrals of free inputs in place of the inputs, squared for one-sided ones.
    #[error("{reason}, with these in place of the inputs: {}", integrals(.integrators, .squared))]
    Integrals {
        /// The condition.
        reason: Box<StlcReason>,
        /// How many integrators stand in front of each input.
        integrators: Vec<usize>,
        /// Whether the input is one-sided.
        squared: Vec<bool>,
    },
    /// Brunovský's theorem.
    #[error("the system is odd about the point and has full dimension (Brunovský)")]
    Odd,
    /// Inputs inside their ranges hold the point.
    #[error("{0} about constant inputs inside their ranges that hold the point")]
    InsideRanges(Box<StlcReason>),
    /// Other inputs than those given hold the point.
    #[error("about {}, which holds the point: {reason}", equations(.inputs))]
    Around {
        /// These inputs.
        inputs: Vec<(String, Function)>,
        /// The verdict around them.
        reason: Box<StlcReason>,
    },
    /// Inputs without bounds, by jumps along their fields.
    #[error(
        "with unbounded inputs, the state can jump along the input fields to states whose drifts together span all directions"
    )]
    Jumps,
    /// A verdict for bounded inputs that says nothing of those without bounds.
    #[error("unbounded inputs may drive the state far away and back; no known condition decides this case")]
    Unbounded,
    /// The ranges do not tell.
    #[error("the inputs at the point are not known to lie in their ranges")]
    NotInRanges,
    /// The same in every mode at the point.
    #[error("in every mode at the point: {0}")]
    EveryMode(Box<StlcReason>),
    /// A continuous function that no mode changes.
    #[error("{0} is constant in every mode at the point")]
    Invariant(Function),
    /// Filippov's solutions stay on a surface.
    #[error(
        "near the point, for all admissible inputs, the motion stays on {0} = 0: no mode leads away from it (Filippov)"
    )]
    Sticks(Function),
    /// An input crosses the surface between two modes.
    #[error(
        "no mode has a drift, an input crosses {0} = 0, and in a mode beside it the input fields have full dimension \
         (Chow–Rashevskii)"
    )]
    Crossing(Function),
    /// The inputs cancel what switches.
    #[error("feedback cancels the difference of the modes, which the input fields span; for the remaining system: {0}")]
    Canceled(Box<StlcReason>),
    /// Something switches at the point, and no condition decides.
    #[error(
        "the equations switch at the point: no half-space is invariant in every mode, sticking is not proved, and the \
         inputs cannot cancel the difference between the drifts of the modes"
    )]
    Switches,
    /// Too many modes meet at the point.
    #[error("{0} modes meet at the point, too many to examine")]
    ManyModes(usize),
    /// The point is in no mode.
    #[error("a unit vector is set-valued at the point, which no mode describes")]
    UnitVector,
    /// The verdict on the affine form does not transfer to the original.
    #[error(transparent)]
    Withheld(Reason),
}

impl StlcReason {
    /// The reason behind one after inputs have canceled what switches.
    pub(crate) fn of_what_is_left(&self) -> &StlcReason {
        match self {
            StlcReason::Canceled(reason) => reason,
            reason => reason,
        }
    }

    /// Whether the verdict rests on inputs that may be far from those at the point.
    pub(crate) fn holds_elsewhere(&self) -> bool {
        match self {
            StlcReason::InsideRanges(_) | StlcReason::Around { .. } | StlcReason::Jumps => true,
            StlcReason::Canceled(reason) => reason.holds_elsewhere(),
            _ => false,
        }
    }
}

/// How the inputs can not change a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Monotone {
    /// It stays constant.
    Constant,
    /// It does not fall.
    Rises,
    /// It does not rise.
    Falls,
}

impl fmt::Display for Monotone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Monotone::Constant => "change",
            Monotone::Rises => "decrease",
            Monotone::Falls => "increase",
        })
    }
}

/// An input that moves along `√scale·Σ coefficients_i g_i`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InputCombination {
    /// Square of the factor.
    pub scale: Rational,
    /// One number per given input.
    pub coefficients: Vec<Rational>,
}

impl fmt::Display for InputCombination {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nonzero = self.coefficients.iter().zip(1..).filter(|(c, _)| **c != Rational::ZERO);
        let terms: Vec<String> =
            nonzero.map(|(c, i)| if *c == Rational::ONE { format!("g{i}") } else { format!("{c}*g{i}") }).collect();
        let sum = terms.join(" + ").replace("+ -", "- ");
        if self.scale == Rational::ONE { f.write_str(&sum) } else { write!(f, "sqrt({})*({sum})", self.scale) }
    }
}

serialized_as_text!(StlcReason);
