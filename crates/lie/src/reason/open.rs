//! Why questions stay open.

use std::fmt;

use bracketry_symbolic::Function;

use crate::as_text::serialized_as_text;
use crate::error::Error;
use crate::reason::contradiction::Contradiction;
use crate::reason::text::equations;
use crate::reason::zero_dynamics::NoZeroDynamics;
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
    /// Two statements exclude each other.
    #[error(transparent)]
    Contradiction(#[from] Contradiction),
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
    #[error("at least {least} and at most the generic dimension: brackets longer than {length} were not formed{limit}")]
    Brackets {
        /// Dimension that was found.
        least: usize,
        /// Length of the longest brackets that were formed.
        length: usize,
        /// What ended the search.
        limit: BracketLimit,
    },
    /// Brockett's condition: [A B] has not full rank and no direction is seen to be missed.
    #[error("not a submersion, and no missed direction was found")]
    NoSubmersion,
    /// The linearization cannot be evaluated.
    #[error("the linearization has no numerical value: a parameter has none")]
    NoNumbers,
    /// The exact rank of Kalman's matrix is not found again in floating point.
    #[error("rounding hides the controllable subspace")]
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
        "the linearization has an unstable uncontrollable mode: no continuously differentiable feedback with the \
         given inputs at the point stabilizes it"
    )]
    UnstableMode,
    /// The zero dynamics have inputs left.
    #[error("holding the outputs leaves inputs free, which may stabilize the remaining dynamics")]
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
    #[error("the derivatives of the zero dynamics at the point do not decide stability")]
    Derivatives,
    /// The integrals that linearize were not found.
    #[error("the linearizing outputs were not found in closed form")]
    NoLinearizingOutputs,
    /// The verdict on the affine form does not transfer: its inputs are not free at the point.
    #[error("at the point, the old inputs cannot vary {} freely in all directions",
        if .inputs.is_empty() { "the inputs of the affine form".to_owned() } else { equations(.inputs) })]
    InputsNotFree {
        /// The new inputs as functions of the old ones.
        inputs: Vec<(String, Function)>,
    },
    /// The verdict on the affine form does not transfer: it keeps inputs near their values at the point.
    #[error("excluded only for {} near the value at the point; other values were not examined", .inputs.join(", "))]
    InputsMayJump {
        /// The inputs that became states.
        inputs: Vec<String>,
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
            BracketLimit::Count => " (too many)",
            BracketLimit::Size => " (too large)",
        })
    }
}

/// Why the dimension over all modes is open.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SwitchingReason {
    /// Lower and upper bound differ.
    #[error(
        "between {least} (the modes and crossings that were examined) and {most} (the fields of all modes together): \
         {why}"
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
    #[error("{0} pairs of modes differ in one sign and in the set they reach, too many to examine")]
    Pairs(usize),
    /// A switching function is affine in no state.
    #[error("{0} = 0 was not solved for a state in which it is affine")]
    Unsolved(Function),
    /// Filippov's solutions may leave what both modes keep.
    #[error("the motion may slide along {0} = 0 and so leave the set that crossing it reaches")]
    Sliding(Function),
    /// A crossing that may not occur.
    #[error("no point of {0} = 0 was found at which the other switching functions have the signs of both modes")]
    NotSeen(Function),
    /// Orbits across several surfaces that differ.
    #[error("orbits across several surfaces differ; only one surface was crossed at a time")]
    SeveralSurfaces,
    /// Which functions are reached was not looked for.
    #[error("the functions that switching reaches are determined only where the fields of all modes act together")]
    FunctionsOpen,
    /// An exact test cannot tell.
    #[error(transparent)]
    Undecided(#[from] Undecided),
}

/// Why a statement at a point where switching functions vanish is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AtSwitch {
    /// Whether the state rests.
    #[error("the modes have different rates at the point; whether a convex combination of them vanishes is undecided")]
    Equilibrium,
    /// Whether feedback stabilizes.
    #[error(
        "the equations switch at the point: the inputs cannot cancel the difference between the drifts of the modes, and no \
         function was found that is monotone along the motions of every mode"
    )]
    Stabilizable,
    /// Brockett's condition.
    #[error(
        "the equations switch at the point: no direction of x' is unattainable in every mode, and the inputs cannot cancel the \
         difference between the drifts of the modes continuously"
    )]
    Brockett,
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
    #[error("{0} switching functions give too many modes")]
    Modes(usize),
    /// The modes do not correspond.
    #[error("the affine form has different switching functions")]
    OtherSwitches,
}

serialized_as_text!(Reason);
