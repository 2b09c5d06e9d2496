//! What counts as finding a hidden effect.

use super::experiment::SliderTruth;
use bracketry_diagnose::{Cause, Report, Verdict};

/// How a verdict compares with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Score {
    /// Just the hidden effects are named, or rightly nothing; effects outside the library: called unknown or unexplained.
    Exact,
    /// Every name is a hidden effect or has one among those it may be confused with, and every hidden effect occurs.
    InSet,
    /// Only some of several hidden effects are named, or occur.
    Partly,
    /// Called unexplained or an unknown term although the library has a name for it.
    Unexplained,
    /// Nothing was found although something is hidden.
    Missed,
    /// A name that is neither a hidden effect nor declared confusable with one.
    WrongName,
    /// Something was found although nothing is hidden.
    FalseAlarm,
}

impl Score {
    /// Compares a report with the truth.
    pub fn of(truth: &SliderTruth, report: &Report) -> Self {
        let hidden: Vec<Option<Cause>> = truth.hidden.iter().map(|hidden| hidden.effect.cause()).collect();
        Self::of_causes(&hidden, report)
    }

    /// Compares a report with the causes that are hidden in the data; an effect outside the library is `None`.
    pub fn of_causes(hidden: &[Option<Cause>], report: &Report) -> Self {
        let named: Vec<Named<'_>> =
            report.causes.iter().map(|c| Named { cause: c.name, confusable: &c.confusable_with }).collect();
        compare(hidden, &named, report.verdict == Verdict::Unexplained)
    }

    /// As reports print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::InSet => "in set",
            Self::Partly => "partly",
            Self::Unexplained => "unexplained",
            Self::Missed => "missed",
            Self::WrongName => "wrong name",
            Self::FalseAlarm => "false alarm",
        }
    }
}

/// A cause that was named, with those that it may be confused with.
struct Named<'a> {
    cause: Cause,
    confusable: &'a [Cause],
}

impl Named<'_> {
    fn covers(&self, cause: Cause) -> bool {
        self.cause == cause || self.confusable.contains(&cause)
    }
}

/// Compares hidden causes (none: outside the library) with named ones.
fn compare(hidden: &[Option<Cause>], named: &[Named<'_>], unexplained: bool) -> Score {
    let found = unexplained || !named.is_empty();
    match (hidden.is_empty(), found) {
        (true, true) => return Score::FalseAlarm,
        (true, false) => return Score::Exact,
        (false, false) => return Score::Missed,
        (false, true) => {}
    }
    let known: Vec<Cause> = hidden.iter().copied().flatten().collect();
    let names: Vec<&Named<'_>> = named.iter().filter(|n| n.cause != Cause::UnknownTerm).collect();
    let unknown = unexplained || names.len() < named.len();
    if names.iter().any(|n| !known.iter().any(|&cause| n.covers(cause))) {
        return Score::WrongName;
    }
    // What has no name must be called unknown, and nothing else.
    let rightly_unknown = unknown == (known.len() < hidden.len());
    if names.is_empty() {
        return if rightly_unknown && known.is_empty() { Score::Exact } else { Score::Unexplained };
    }
    let occurs = |&cause: &Cause| names.iter().any(|n| n.covers(cause));
    if !rightly_unknown || names.len() < known.len() || !known.iter().all(occurs) {
        return Score::Partly;
    }
    let is_named = |&cause: &Cause| names.iter().any(|n| n.cause == cause);
    if names.len() == known.len() && known.iter().all(is_named) { Score::Exact } else { Score::InSet }
}
