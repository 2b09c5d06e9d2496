//! Bounds that hold with a probability.

use serde::Serialize;

/// What the controller is taken to do about deviations from the plan, where margins are computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MarginFeedback {
    /// The feedback of the infinite horizon of the stage cost.
    Riccati,
    /// Nothing: deviations grow as the model lets them.
    OpenLoop,
}

/// The margin of one bound or constraint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChanceMargin {
    /// Its name in the problem file.
    pub name: String,
    /// Probability with which each of its ends shall hold at a grid point.
    pub probability: f64,
    /// Margin at the first grid point after the start, in its unit.
    pub first: f64,
    /// Margin at the end of the horizon.
    pub last: f64,
}

/// The margins of a problem with noise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChanceReport {
    /// What is taken to hold the state near the plan.
    pub feedback: MarginFeedback,
    /// Bounds and constraints with a margin.
    pub margins: Vec<ChanceMargin>,
}
