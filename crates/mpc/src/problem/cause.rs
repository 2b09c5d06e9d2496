//! What probably lies behind a run that does not do what was asked.

use std::fmt;

use serde::Serialize;

/// What probably lies behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The programs did not reach their tolerance.
    Inaccurate,
    /// The plant's friction is smoothed in the controller's model.
    SmoothedFriction,
    /// Inputs act later than the controller knows.
    Delay,
    /// The plant is another model.
    Plant,
    /// The first plan did not converge.
    Plan,
    /// The horizon moves on, and its end with it.
    MovingHorizon,
    /// One program per sample does not follow the problem.
    OneProgram,
    /// A minimum that is only local.
    LocalMinimum,
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Inaccurate => "most programs miss their tolerance; give a [guess], or [scale] near the real sizes",
            Self::SmoothedFriction => {
                "the controller's model has smoothed friction, but the plant sticks; write method = \"stick-slip\""
            }
            Self::Delay => {
                "inputs act later than the controller assumes; write compensate_delay = true, and give the input \
                 delays in its model"
            }
            Self::Plant => "the plant is not the controller's model",
            Self::Plan => "the plan did not converge; give a [guess], or raise max_iterations",
            Self::MovingHorizon => {
                "a moving horizon never reaches its end; write method = \"plan\", whose horizon ends with the \
                 run"
            }
            Self::OneProgram => {
                "one QP per sample does not suffice; write method = \"sqp\", or raise initial_iterations"
            }
            Self::LocalMinimum => {
                "give a [guess] closer to the desired result, a longer horizon, or a cost that leads there"
            }
        })
    }
}
