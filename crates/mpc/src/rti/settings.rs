//! Settings of the real-time iteration.

use crate::controller::FailurePolicy;
use crate::error::{MpcError, check_value};
use crate::ocp::Ocp;
use crate::qp::QpSettings;

/// What happens to the horizon from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Horizon {
    /// It keeps its length and moves on.
    Receding,
    /// Its end stays where it is; after it, the inputs are those of [`RtiSettings::rest_input`]. With fewer than `min_steps`
    /// intervals left the last trajectory is played out.
    Shrinking {
        /// Fewest intervals for which a program is solved.
        min_steps: usize,
    },
}

/// What is done before the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preparation {
    /// Linearization along the shifted trajectory.
    Linearize,
    /// The advanced step: programs for the state that the model predicts, then linearization along their solution. The
    /// measurement is answered by one more program.
    AdvancedStep {
        /// Number of programs, at least 1; fewer when they settle, or when the time limit comes first.
        programs: usize,
    },
    /// The same, but the measurement is answered by the tangential predictor: the solution moved along its derivative with the
    /// active inequalities held, which needs no program. Where that leads an input out of its bounds, a program is solved.
    AdvancedStepTangential {
        /// Number of programs, at least 1.
        programs: usize,
    },
}

/// Settings of [`Rti`](crate::Rti).
#[derive(Clone, Debug, PartialEq)]
pub struct RtiSettings {
    /// Receding or shrinking horizon.
    pub horizon: Horizon,
    /// Smoothing width of switching functions; `None` keeps what the dynamics have.
    pub smoothing: Option<f64>,
    /// What is done before the measurement.
    pub preparation: Preparation,
    /// Weight λ of the proximal term; 0 is the plain real-time iteration.
    pub proximal: f64,
    /// Whether a step that does not lower the merit is shortened (to 1/2, 1/4, 1/10) or left out.
    pub guarded: bool,
    /// Input after the end of a shrinking horizon, and when everything planned has been used up; when empty, the one
    /// closest to zero within the bounds.
    pub rest_input: Vec<f64>,
    /// What is applied when a sample has no solution.
    pub policy: FailurePolicy,
    /// Largest number of programs per sample, at least 1. Those after the first are solved only while the step still changes
    /// something and, under a time limit, while the time left is enough for one more like the last.
    pub iterations: usize,
    /// Time of a sample, s, preparation included: what linearizing leaves of it is the time limit of the program, and a
    /// sample without a solution by then falls to the failure policy.
    pub time_limit: f64,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
}

impl Default for RtiSettings {
    fn default() -> Self {
        Self {
            horizon: Horizon::Receding,
            smoothing: None,
            preparation: Preparation::Linearize,
            proximal: 0.0,
            guarded: false,
            rest_input: Vec::new(),
            policy: FailurePolicy::ShiftedInput,
            iterations: 1,
            time_limit: f64::INFINITY,
            qp: QpSettings::default(),
        }
    }
}

impl RtiSettings {
    /// Whether the settings are in their ranges and fit the problem.
    pub(super) fn check(&self, ocp: &Ocp) -> Result<(), MpcError> {
        check_value(self.iterations > 0, "the number of iterations per sample", 0.0, "give at least 1")?;
        check_value(
            self.time_limit > 0.0,
            "the time limit of a sample",
            self.time_limit,
            "give a positive number of seconds, or infinity for none",
        )?;
        let programs = match self.preparation {
            Preparation::Linearize => 1,
            Preparation::AdvancedStep { programs } | Preparation::AdvancedStepTangential { programs } => programs,
        };
        check_value(programs > 0, "the number of programs solved ahead", 0.0, "give at least 1")?;
        if let (Preparation::AdvancedStepTangential { .. }, Some(what)) = (self.preparation, not_tangential(ocp)) {
            let remedy =
                "prepare by Preparation::AdvancedStep: the tangential predictor supports bounds and targets only";
            check_value(false, format!("the number of {what}"), 1.0, remedy)?;
        }
        let shrinks = matches!(self.horizon, Horizon::Shrinking { .. });
        if let Some(length) = ocp.lengths.iter().find(|l| shrinks && **l != ocp.dt) {
            let remedy = "a horizon that shrinks by the sampling period has intervals of one length";
            check_value(false, "the length of an interval", *length, remedy)?;
        }
        self.policy.check(ocp.states(), ocp.inputs())
    }
}

/// What the tangential predictor cannot hold.
fn not_tangential(ocp: &Ocp) -> Option<&'static str> {
    let cases = [
        (!ocp.path_constraints.is_empty(), "path constraints"),
        (ocp.row_functions(1).count() > ocp.path_constraints.len(), "absolute values in the cost"),
        (!ocp.norm_constraints.is_empty(), "norm constraints"),
        (!ocp.move_blocks.is_empty(), "move blocks"),
        (ocp.branching.is_some(), "scenario trees"),
        (ocp.terminal_set.is_some(), "terminal sets"),
    ];
    cases.into_iter().find(|(there, _)| *there).map(|(_, what)| what)
}
