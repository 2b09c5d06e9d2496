//! A run beside a log of the same experiment.

use serde::Serialize;

use super::pose_deviations::PoseDeviations;
use super::sign_comparison::{SignComparison, SignStatus};

/// How far a run is from a log over their common time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The log.
    pub log: String,
    /// Over their whole common time.
    #[serde(flatten)]
    pub whole: PoseDeviations,
    /// Whether run and log took the same signs of the amplitude; none for experiments without amplitude law and on a logged
    /// motion of the plate.
    pub signs: Option<SignComparison>,
}

impl Comparison {
    /// Whether a sign of the amplitude is a matter of chance, so that only the time before it counts.
    pub fn is_undecided(&self) -> bool {
        self.signs.as_ref().is_some_and(|signs| signs.status() == SignStatus::Undecided)
    }
}
