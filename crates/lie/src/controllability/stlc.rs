//! The verdict on small-time local controllability at an equilibrium, as data; `decide.rs` has the conditions.

use std::fmt;

use serde::Serialize;

use crate::controllability::sussmann::Obstruction;
use crate::reason::StlcReason;
use crate::undecided::Undecided;

/// Whether the inputs reach a full neighborhood in arbitrarily short time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// A sufficient condition holds.
    Yes,
    /// A necessary condition fails.
    No,
    /// Neither is known.
    Inconclusive,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Verdict::Yes => "yes",
            Verdict::No => "no",
            Verdict::Inconclusive => "inconclusive",
        })
    }
}

/// What Sussmann's general sufficient condition says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GeneralCondition {
    /// It holds for some weights.
    Holds,
    /// For all weights that were tried a bad bracket is not neutralized.
    Obstructed,
    /// For some weights the brackets became too many or too large.
    Unknown,
}

/// Small-time local controllability (STLC) at the point x0: for every T > 0, the states that are reached within T contain a
/// neighborhood of x0.
///
/// Inputs take the values of their ranges; one without a range takes all real numbers, and trajectories may leave the
/// neighborhood of x0 meanwhile. With bounded inputs they cannot go far in a short time; the verdict for those, which is
/// the one of the literature (|u| ≤ 1), is in `bounded` where it differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stlc {
    /// The verdict.
    pub verdict: Verdict,
    /// The condition that holds or fails.
    pub reason: StlcReason,
    /// Weights, of the drift and then of the inputs (one number if they are all equal), for which
    /// Sussmann's condition holds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<Vec<u32>>,
    /// What Sussmann's condition says; absent where a simpler test decides first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub general_condition: Option<GeneralCondition>,
    /// Weights that were tried.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub weights_tried: Vec<Vec<u32>>,
    /// The first bad bracket that is not neutralized, for the first of the weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obstruction: Option<Obstruction>,
    /// Where some input has no finite range: the verdict for inputs within any bounds around their values at the point, if it is another one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounded: Option<BoundedStlc>,
}

/// Small-time local controllability with inputs u that are bounded by a constant, |u − u0| ≤ M, for every M.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundedStlc {
    /// The verdict.
    pub verdict: Verdict,
    /// The condition that holds or fails.
    pub reason: StlcReason,
}

impl Stlc {
    /// The verdict for bounded inputs.
    pub fn with_bounded_inputs(&self) -> Verdict {
        self.bounded.as_ref().map_or(self.verdict, |b| b.verdict)
    }

    pub(crate) fn new(verdict: Verdict, reason: StlcReason) -> Self {
        Stlc {
            verdict,
            reason,
            weights: None,
            general_condition: None,
            weights_tried: Vec::new(),
            obstruction: None,
            bounded: None,
        }
    }

    /// With the weights for which Sussmann's condition holds.
    pub(crate) fn holding(self, weights: Vec<u32>) -> Self {
        Stlc { weights: Some(weights), general_condition: Some(GeneralCondition::Holds), ..self }
    }

    /// No verdict where a test gave up.
    pub(crate) fn or_inconclusive(decided: Result<Self, Undecided>) -> Self {
        decided.unwrap_or_else(|why| Stlc::inconclusive(why.into()))
    }

    /// No verdict, for a reason that lies outside of the brackets.
    pub fn inconclusive(reason: StlcReason) -> Self {
        Stlc::new(Verdict::Inconclusive, reason)
    }

    /// The orbit is a manifold of lower dimension (Nagano–Sussmann).
    pub(crate) fn not_accessible(dimension: usize, states: usize) -> Self {
        Stlc::new(Verdict::No, StlcReason::NotAccessible { dimension, states })
    }
}
