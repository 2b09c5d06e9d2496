//! What verdicts rest on, and why questions stay open.

use std::fmt;

use crate::as_text::serialized_as_text;
use bracketry_symbolic::{Function, Rational};

use crate::algebra::word::Bracket;
use crate::error::Error;
use crate::undecided::Undecided;

/// Why a question stays open.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Reason {
    /// An exact test cannot tell.
    #[error(transparent)]
    Undecided(#[from] Undecided),
    /// The question has no meaning there.
    #[error(transparent)]
    Error(#[from] Error),
    /// The zero dynamics were not found.
    #[error(transparent)]
    ZeroDynamics(#[from] NoZeroDynamics),
    /// The family of constant inputs was not compared with the affine form.
    #[error(transparent)]
    Family(#[from] FamilyReason),
    /// What switching between modes reaches is open.
    #[error(transparent)]
    Switching(#[from] SwitchingReason),
    /// Something switches at the point.
    #[error(transparent)]
    AtSwitch(#[from] AtSwitch),
    /// A bracket has too long an expression.
    #[error("too long to print")]
    Unprintable,
    /// The smoothed model has no point.
    #[error("the smoothed model has no point")]
    NoPoint,
    /// Not all brackets were formed at the point.
    #[error(
        "at least {least} (the generic dimension bounds it above): brackets longer than {length} were not formed{limit}"
    )]
    Brackets {
        /// Dimension that was found.
        least: usize,
        /// Length of the longest brackets that were formed.
        length: usize,
        /// What ended the search.
        limit: BracketLimit,
    },
    /// Brockett's condition: [A B] has not full rank and no direction is seen to be missed.
    #[error("neither a submersion nor seen to miss a direction")]
    NoSubmersion,
    /// The linearization cannot be evaluated.
    #[error("the linearization has no numerical value: a parameter has none")]
    NoNumbers,
    /// The exact rank of Kalman's matrix is not found again in floating point.
    #[error("the controllable subspace is not clear of rounding")]
    Rounding,
    /// An uncontrollable eigenvalue decides nothing.
    #[error("the linearization has an uncontrollable eigenvalue on, or too near, the imaginary axis")]
    NearAxis,
    /// An uncontrollable eigenvalue is exactly on the axis.
    #[error("the linearization has an uncontrollable eigenvalue on the imaginary axis")]
    OnAxis,
    /// The eigenvalues were not found.
    #[error("the QR algorithm for the eigenvalues did not converge")]
    NoConvergence,
    /// Smooth feedback cannot stabilize; other feedback may.
    #[error(
        "the linearization has an unstable uncontrollable mode: no continuously differentiable feedback that keeps the \
         inputs of the point there stabilizes"
    )]
    UnstableMode,
    /// The zero dynamics have inputs left.
    #[error("the outputs leave inputs free, which may stabilize what is left")]
    FreeInputs,
    /// The point is no equilibrium of the zero dynamics.
    #[error("the point is not an equilibrium of the zero dynamics")]
    NoEquilibrium,
    /// Whether it is one is open.
    #[error("whether the point is an equilibrium of the zero dynamics is not decided")]
    EquilibriumOpen,
    /// The zero dynamics cannot be evaluated.
    #[error("the linearization of the zero dynamics has no numerical value")]
    ZeroDynamicsNoNumbers,
    /// The linearized zero dynamics decide nothing.
    #[error("the zero dynamics have eigenvalues on, or too near, the imaginary axis")]
    ZeroDynamicsNearAxis,
    /// The linearized zero dynamics are exactly on the axis.
    #[error("the zero dynamics have eigenvalues on the imaginary axis")]
    ZeroDynamicsOnAxis,
    /// Nor do higher derivatives.
    #[error("the derivatives of the zero dynamics at the point do not decide")]
    Derivatives,
    /// The integrals that linearize were not found.
    #[error("the linearizing outputs were not found in closed form")]
    NoLinearizingOutputs,
    /// The verdict on the affine form does not transfer: its inputs are not free at the point.
    #[error("at the point the old inputs do not move {} freely to all sides", equations(.inputs))]
    InputsNotFree {
        /// The new inputs as functions of the old ones.
        inputs: Vec<(String, Function)>,
    },
    /// The verdict does not transfer: an input is at an end of its range.
    #[error("{input} is at an end of its range at the point")]
    EndOfRange {
        /// The input.
        input: String,
    },
}

/// What ended a search among brackets at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BracketLimit {
    /// The length that is allowed.
    Length,
    /// The number that is allowed.
    Count,
    /// The size that is allowed.
    Size,
}

impl fmt::Display for BracketLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            BracketLimit::Length => "",
            BracketLimit::Count => ": they are too many",
            BracketLimit::Size => ": they are too large",
        })
    }
}

/// Why the dimension over all modes is open.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SwitchingReason {
    /// Lower and upper bound differ.
    #[error(
        "between {least} (the modes and crossings that were followed) and {most} (the fields of all modes together): {why}"
    )]
    Bounds {
        /// Dimension of what is reached at least.
        least: usize,
        /// Dimension that nothing exceeds.
        most: usize,
        /// What could not be followed.
        why: Box<SwitchingReason>,
    },
    /// No mode occurs.
    #[error("no point was found at which the signs of a mode hold")]
    NoMode,
    /// There are too many pairs of modes.
    #[error("{0} pairs of modes differ in one sign and in what they reach, more than are followed")]
    Pairs(usize),
    /// A switching function is affine in no state.
    #[error("{0} = 0 was not solved for a state in which it is affine")]
    Unsolved(Function),
    /// Filippov's solutions may leave what both modes keep.
    #[error("the motion may slide along {0} = 0, which can lead out of what crossing it reaches")]
    Sliding(Function),
    /// A crossing that may not occur.
    #[error("no point of {0} = 0 was found at which the other switching functions have the signs of both modes")]
    NotSeen(Function),
    /// Orbits across several surfaces that differ.
    #[error("orbits across several surfaces differ, and were followed across one at a time")]
    SeveralSurfaces,
    /// Which functions are reached was not looked for.
    #[error("which functions switching reaches is found only where the fields of all modes act together")]
    FunctionsOpen,
    /// An exact test cannot tell.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

/// Why a statement at a point where switching functions vanish is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AtSwitch {
    /// Whether the state rests.
    #[error("the modes at the point have different rates there, and whether a mixture of them vanishes is not decided")]
    Equilibrium,
    /// Whether feedback stabilizes.
    #[error(
        "the equations switch at the point: the inputs do not cancel the difference of the modes, and no function is seen to \
         change to one side only in every mode"
    )]
    Stabilizable,
    /// Brockett's condition.
    #[error(
        "the equations switch at the point: no direction is missed in every mode, and the inputs do not cancel the difference \
         of the modes continuously"
    )]
    Brockett,
}

/// Why there are no zero dynamics in closed form.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoZeroDynamics {
    /// A function on the set that must vanish was not solved for a state.
    #[error("{constraint} = 0 was not solved for a state")]
    Unsolved {
        /// The function.
        constraint: Function,
    },
    /// Several functions may vanish, and the point does not tell which.
    #[error("{constraint} = 0 has several branches; a point on one of them would select it")]
    Branches {
        /// The product.
        constraint: Function,
    },
    /// A derivative of an output cannot vanish.
    #[error("no input keeps the outputs there: {derivative} would have to vanish")]
    Empty {
        /// The derivative.
        derivative: Function,
    },
    /// An exact test cannot tell.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

impl From<bracketry_symbolic::Undecided> for NoZeroDynamics {
    fn from(why: bracketry_symbolic::Undecided) -> Self {
        NoZeroDynamics::Undecided(why.into())
    }
}

/// Why the family of constant inputs was not compared with the affine form.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FamilyReason {
    /// The affine form has other states.
    #[error("the affine form does not keep the states of the system and the derivatives of its inputs")]
    OtherStates,
    /// A switching function that is not expanded into modes.
    #[error("the switching function {0} depends on an input and on the state")]
    Switch(Function),
    /// More modes than are looked at.
    #[error("there are {0} switching functions, which gives too many modes")]
    Modes(usize),
    /// The modes do not correspond.
    #[error("the affine form has other switching functions")]
    OtherSwitches,
}

/// What a verdict on small-time local controllability rests on, or why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StlcReason {
    /// Bounded inputs cannot hold the state.
    #[error("the drift does not vanish at the point and no input balances it")]
    NotBalanced,
    /// Other inputs may hold the state.
    #[error("the point is no equilibrium for the inputs given with it")]
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
    #[error("from its value at the point {function} can {change}, whatever the inputs{}",
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
    #[error("the bad bracket {bracket} is not neutralized with weights {weights:?}, nor are others with {further} \
        further choices of weights{}", if *.too_many { ", of which some take too many brackets" } else { "" })]
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
    #[error("the brackets that Sussmann's condition asks for are too many")]
    TooManyBrackets,
    /// Stefani's necessary condition fails for this even power.
    #[error(
        "ad_g^{0} f at the point is no combination of brackets with fewer factors g (Stefani's necessary condition)"
    )]
    Stefani(usize),
    /// A definite quadratic form, of brackets of this depth.
    #[error("second-order brackets of {} with f are definite across all that the linearization reaches",
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
    #[error("inputs move to one side only and the point is no equilibrium")]
    OneSidedNoEquilibrium,
    /// No inputs in their ranges hold the state, by this linear function.
    #[error("the rate of {0} at the point is positive for all inputs in their ranges")]
    Separated(Function),
    /// All inputs push to one side.
    #[error("all inputs that act at the point push to one side of it, and their ranges are one-sided")]
    OneSidedCone,
    /// No condition for one-sided inputs decides.
    #[error("inputs move to one side only, and no condition for such inputs decides")]
    OneSidedOpen,
    /// The other inputs suffice.
    #[error("{0} with the inputs alone that move to both sides")]
    TwoSidedInputs(Box<StlcReason>),
    /// A condition holds for integrals of free inputs in place of the inputs, squared for one-sided ones.
    #[error("{reason} for {} in place of the inputs", integrals(.integrators, .squared))]
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
    #[error("{0} around constant inputs inside their ranges that hold the point")]
    InsideRanges(Box<StlcReason>),
    /// Other inputs than those given hold the point.
    #[error("around {}, which holds the point: {reason}", equations(.inputs))]
    Around {
        /// These inputs.
        inputs: Vec<(String, Function)>,
        /// The verdict around them.
        reason: Box<StlcReason>,
    },
    /// Inputs without bounds, by jumps along their fields.
    #[error("inputs without bounds jump along their fields to where the drift points to all sides")]
    Jumps,
    /// A verdict for bounded inputs that says nothing of those without bounds.
    #[error("inputs without a range may take the state far and back, for which no condition decides")]
    Unbounded,
    /// The ranges do not tell.
    #[error("the inputs at the point are not seen to lie in their ranges")]
    NotInRanges,
    /// The same in every mode at the point.
    #[error("in every mode at the point: {0}")]
    EveryMode(Box<StlcReason>),
    /// A continuous function that no mode changes.
    #[error("{0} never changes, in any mode at the point")]
    Invariant(Function),
    /// Filippov's solutions stay on a surface.
    #[error("whatever the inputs in their ranges, the motion stays on {0} = 0: both modes drive it there (Filippov)")]
    Sticks(Function),
    /// The inputs cancel what switches.
    #[error("feedback cancels the difference of the modes, which the input fields span; of what is left: {0}")]
    Canceled(Box<StlcReason>),
    /// Something switches at the point, and no condition decides.
    #[error(
        "the equations switch at the point: no half-space holds in every mode, the motion is not seen to stick, and the inputs \
         do not cancel the difference of the modes"
    )]
    Switches,
    /// Too many modes meet at the point.
    #[error("{0} modes meet at the point, more than are looked at")]
    ManyModes(usize),
    /// The point is in no mode.
    #[error("a unit vector takes a set of values at the point, which no mode describes")]
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
            Monotone::Constant => "neither rise nor fall",
            Monotone::Rises => "not fall",
            Monotone::Falls => "not rise",
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

/// What a verdict on stabilizability rests on, or why there is none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StabilizableReason {
    /// Kalman's condition.
    #[error("the linearization is controllable")]
    Controllable,
    /// The uncontrollable eigenvalues have negative real parts.
    #[error("the uncontrollable modes of the linearization decay")]
    ModesDecay,
    /// A linear system with an uncontrollable eigenvalue in the right half-plane.
    #[error("the linearization has an unstable uncontrollable mode")]
    UnstableMode,
    /// A linear system with an uncontrollable eigenvalue on the imaginary axis.
    #[error("the system is linear and has an uncontrollable mode on the imaginary axis")]
    ModeOnAxis,
    /// Coron's theorem.
    #[error("by continuous time-periodic feedback, from small-time controllability (Coron)")]
    Periodic,
    /// A function that never changes to one side, so that it does not return.
    #[error("{function} can {change} near the point, whatever the inputs, in any mode")]
    OneWay {
        /// The function.
        function: Function,
        /// How it can not change.
        change: Monotone,
    },
    /// The inputs cancel what switches.
    #[error("feedback cancels the difference of the modes, which the input fields span; of what is left: {0}")]
    Canceled(Box<StabilizableReason>),
    /// Not decided.
    #[error(transparent)]
    Open(Reason),
}

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
    #[error("the zero dynamics begin with a multiple of {state}^{order}")]
    Order {
        /// The coordinate.
        state: String,
        /// The first power that occurs.
        order: usize,
    },
    /// A Lyapunov function.
    #[error("the Lyapunov function {function} falls along all motions near the equilibrium (LaSalle)")]
    Lyapunov {
        /// The function.
        function: Function,
    },
    /// The same backwards in time.
    #[error("{function} rises along all motions near the equilibrium, which is unstable")]
    Repels {
        /// The function.
        function: Function,
    },
    /// A first integral.
    #[error("{function} never changes{}", if *.stable {
        " and has a strict extremum at the equilibrium: only stable, not asymptotically"
    } else {
        ", so that the motions nearby do not all approach the equilibrium"
    })]
    Conserved {
        /// The integral.
        function: Function,
        /// Whether its second derivatives are definite, so that the equilibrium is stable.
        stable: bool,
    },
    /// s' = c s^k + … on a center manifold of dimension 1.
    #[error("on the center manifold the motion begins with a {} multiple of the power {order} (Carr 1981)",
        if *.falls { "negative" } else { "positive" })]
    CenterManifold {
        /// k.
        order: usize,
        /// Whether c < 0.
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
    #[error("not strongly accessible: some function of the state no input influences")]
    NotAccessible,
    /// Flat by static feedback.
    #[error("linearizable by static feedback")]
    StaticFeedback,
    /// With one input, flatness is linearizability by static feedback.
    #[error(
        "a system with one input is flat only if it is linearizable by static feedback (Charlet, Lévine and Marino 1989)"
    )]
    OneInput,
    /// The velocities that the inputs give do not form a ruled manifold.
    #[error(
        "no line lies in the set of velocities that the inputs give, which is no ruled manifold (Rouchon 1994, Sluis 1993)"
    )]
    NotRuled,
    /// The new inputs of the affine form are not independent functions of the old ones.
    #[error(
        "the affine form has inputs that depend on each other; its flatness says nothing of the model, and the model's velocities are not seen to exclude it"
    )]
    DependentInputs,
    /// m = n − 1.
    #[error("accessible with one input less than states (Charlet, Lévine and Marino 1989)")]
    OneInputLess,
    /// m = n − 2 without drift.
    #[error("accessible without drift, with two inputs less than states (Martin and Rouchon 1995)")]
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

serialized_as_text!(Reason, StlcReason, StabilizableReason, MinimumPhaseReason, FlatnessReason);

/// Such as `w1, the integral of w2, the square of the integral of w3`.
fn integrals(integrators: &[usize], squared: &[bool]) -> String {
    let one = |((&count, &squared), i): ((&usize, &bool), usize)| {
        let of = match count {
            0 => format!("w{i}"),
            1 => format!("the integral of w{i}"),
            _ => format!("the integral, of order {count}, of w{i}"),
        };
        if squared { format!("the square of {of}") } else { of }
    };
    let list: Vec<String> = integrators.iter().zip(squared).zip(1..).map(one).collect();
    list.join(", ")
}

fn texts(list: &[impl fmt::Display]) -> String {
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

fn equations(list: &[(String, Function)]) -> String {
    texts(&list.iter().map(|(name, e)| format!("{name} = {e}")).collect::<Vec<_>>())
}
