//! What was found, before it is written down.

use super::explanation::Explanation;
use super::noise::Scatter;

/// A cause's rivals: candidate and explanation with it in the cause's place, the best first.
pub(crate) type Rivals = Vec<(usize, Explanation)>;

/// What was found, before it is written down.
pub(crate) struct Findings {
    /// The model with parameters refitted.
    pub(crate) base: Explanation,
    /// The explanation, empty if there is none.
    pub(crate) chosen: Explanation,
    /// Rivals of each of its members.
    pub(crate) rivals: Vec<Rivals>,
    /// The scatter around it.
    pub(crate) scatter: Scatter,
    /// Candidates at their trials that were put against the data.
    pub(crate) tests: f64,
    /// Smallest of the p-values by which the alarm was raised.
    pub(crate) alarm: f64,
    /// How it ended.
    pub(crate) ending: Ending,
}

/// How the search for causes ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Ending {
    /// The residual is noise.
    Quiet,
    /// The residual is correlated, but no candidate explains it, and it is hardly larger than the noise.
    Correlated,
    /// The named causes explain the residual.
    Explained,
    /// The named causes explain the given share of the excess.
    Partly(f64),
    /// They explain too little; the share of the best attempt.
    Unexplained(f64),
    /// What was tried explains the given share of the excess in the data of the fit, but predicts held-out data no better.
    Refuted(f64),
}
