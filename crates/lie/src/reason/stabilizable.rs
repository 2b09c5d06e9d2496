//! What verdicts on stabilizability rest on.

use bracketry_symbolic::{Function, Rational};

use crate::as_text::serialized_as_text;
use crate::reason::feedback::MinimumPhaseReason;
use crate::reason::open::Reason;
use crate::reason::stlc::Monotone;
use crate::reason::text::{equations, texts};

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
    /// Orbits of lower dimension foliate a neighborhood of the point.
    #[error("near the point, the state stays on sets of dimension {dimension} of {states} for all inputs (Frobenius)")]
    Leaves {
        /// Dimension of the orbits.
        dimension: usize,
        /// Number of states.
        states: usize,
    },
    /// Functions that no input influences move away from their values at the point.
    #[error("functions that no input influences have autonomous dynamics with an unstable linearization")]
    UnstableQuotient,
    /// Terms of higher order in what no input influences do not attract.
    #[error(
        "functions that no input influences have autonomous dynamics, for which the equilibrium is not asymptotically stable: {0}"
    )]
    QuotientDoesNotAttract(MinimumPhaseReason),
    /// A is Hurwitz.
    #[error("the linearization is asymptotically stable with the inputs of the point")]
    Stable,
    /// Terms of higher order decide.
    #[error("the equilibrium is asymptotically stable with the inputs of the point")]
    StableByItself,
    /// Linear feedback around other values of inputs that together do not move the state at the point.
    #[error("with {} at the point, the uncontrollable modes of the linearization decay", equations(.inputs))]
    OtherInputs {
        /// These inputs, with their values at the point.
        inputs: Vec<(String, Function)>,
    },
    /// Coron's theorem, with integrators.
    #[error("by continuous time-periodic dynamic feedback, from small-time controllability (Coron)")]
    PeriodicDynamic,
    /// Kawski's theorem.
    #[error("by Hölder continuous feedback, from small-time controllability in the plane (Kawski 1989)")]
    Planar,
    /// Coron's theorem.
    #[error("by continuous time-periodic feedback, from small-time controllability (Coron)")]
    Periodic,
    /// Signs of the rate of a function that the input does not influence.
    #[error(
        "by continuous feedback in the plane: near the point, {function} can fall where it is above its value there and rise where \
         it is below (Dayawansa, Martin, and Knowles 1990)"
    )]
    PlanarSigns {
        /// The function.
        function: Function,
    },
    /// One mode on the imaginary axis, which decays along states that the inputs otherwise hold at rest.
    #[error(
        "by Lipschitz continuous feedback: along states that the inputs otherwise hold at rest, the critical mode {function} decays \
         at a rate of {} (Aeyels 1985)", of_order(.orders)
    )]
    CriticalMode {
        /// The mode.
        function: Function,
        /// The powers of the mode to which its rate is proportional, above and below the point.
        orders: [Rational; 2],
    },
    /// Several uncontrollable modes with the eigenvalue 0.
    #[error(
        "by Lipschitz continuous feedback: along states that the inputs otherwise hold at rest, the critical modes {} decay (Aeyels 1985)",
        texts(.functions)
    )]
    CriticalModes {
        /// The modes.
        functions: Vec<Function>,
    },
    /// A pair of eigenvalues ±iω.
    #[error(
        "by smooth feedback that makes the first focal value of the uncontrollable pair of eigenvalues on the imaginary axis negative \
         (Abed and Fu 1986)"
    )]
    OscillatingPair,
    /// A function that never changes to one side, so that it does not return.
    #[error("{function} cannot {change} near the point for any inputs")]
    OneWay {
        /// The function.
        function: Function,
        /// How it can not change.
        change: Monotone,
    },
    /// A function that does not fall where it is above its value at the point, or does not rise where it is below.
    #[error("where {function} is {} its value at the point, it cannot {} near the point for any inputs",
        if *.above { "above" } else { "below" }, if *.above { Monotone::Rises } else { Monotone::Falls })]
    NoReturn {
        /// The function.
        function: Function,
        /// Whether that is so above its value at the point, else below.
        above: bool,
    },
    /// A form of uncontrollable modes that does not fall.
    #[error(
        "{function}, which is positive at some points arbitrarily near the point, cannot decrease near it for any inputs"
    )]
    Grows {
        /// The form.
        function: Function,
    },
    /// A function that is constant in every mode.
    #[error("{0} is constant, so states with another value of it do not approach the point")]
    Conserved(Function),
    /// Bounded inputs hold the state on a surface.
    #[error(
        "near the point, for all admissible inputs, states on {surface} = 0 stay there, and {kept} is constant there"
    )]
    Sticks {
        /// The switching function.
        surface: Function,
        /// What keeps its value on the surface.
        kept: Function,
    },
    /// The inputs cancel what switches.
    #[error("feedback cancels the difference of the modes, which the input fields span; for the remaining system: {0}")]
    Canceled(Box<StabilizableReason>),
    /// Not decided.
    #[error(transparent)]
    Open(Reason),
}

impl StabilizableReason {
    /// Whether continuous feedback of the state near the values of the inputs at the point stabilizes though linear feedback may
    /// not.
    pub(crate) fn is_by_continuous_state_feedback(&self) -> bool {
        use StabilizableReason::{CriticalMode, CriticalModes, OscillatingPair, Planar, PlanarSigns};
        matches!(self, Planar | PlanarSigns { .. } | CriticalMode { .. } | CriticalModes { .. } | OscillatingPair)
    }
}

/// Of which orders in a mode its rates on both sides are.
fn of_order([above, below]: &[Rational; 2]) -> String {
    if above == below { format!("order {above}") } else { format!("order {above} above and {below} below the point") }
}

serialized_as_text!(StabilizableReason);
