//! What counts as finding a hidden effect.

use super::SliderTruth;
use crate::Cause;

/// A cause that a diagnosis names, with those that it cannot tell from it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// The cause.
    pub cause: Cause,
    /// The causes that it may be confused with.
    pub confusable: Vec<Cause>,
}

/// How a verdict compares with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Score {
    /// Just the hidden effects are named, or rightly nothing; for effects outside the library: called unknown or unexplained.
    Exact,
    /// Every name is a hidden effect or has one among those it may be confused with, and every hidden effect occurs.
    InSet,
    /// Only some of several hidden effects are named, or occur.
    Partly,
    /// Nothing was found although something is hidden.
    Missed,
    /// Something with a name in the library was found that has none in the verdict: unexplained, or an unknown term.
    Unexplained,
    /// A name that is neither a hidden effect nor declared confusable with one.
    WrongName,
    /// Something was found although nothing is hidden.
    FalseAlarm,
}

impl Score {
    /// Compares the truth with a verdict: the causes named, and whether the verdict says that something remains unexplained.
    pub fn of(truth: &SliderTruth, named: &[Named], unexplained: bool) -> Self {
        let found = unexplained || !named.is_empty();
        if truth.hidden.is_empty() {
            return if found { Self::FalseAlarm } else { Self::Exact };
        }
        if !found {
            return Self::Missed;
        }
        let hidden: Vec<Option<Cause>> = truth.hidden.iter().map(|hidden| hidden.effect.cause()).collect();
        let with_name = |named: &&Named| named.cause != Cause::UnknownTerm;
        let candidates: Vec<&Named> = named.iter().filter(with_name).collect();
        let unknown = unexplained || candidates.len() < named.len();
        let covers = |named: &Named, cause: Cause| named.cause == cause || named.confusable.contains(&cause);
        let wrong = |named: &&&Named| !hidden.iter().flatten().any(|&cause| covers(named, cause));
        if candidates.iter().any(|named| wrong(&named)) {
            return Self::WrongName;
        }
        let outside = hidden.contains(&None);
        if candidates.is_empty() {
            return if outside && hidden.len() == 1 { Self::Exact } else { Self::Unexplained };
        }
        let known = hidden.iter().flatten().count();
        let everything = hidden.iter().flatten().all(|&cause| candidates.iter().any(|named| covers(named, cause)));
        if !everything || candidates.len() < known {
            return Self::Partly;
        }
        let is_named = |cause| candidates.iter().any(|named| named.cause == cause);
        let exactly = candidates.len() == known && hidden.iter().flatten().all(|&cause| is_named(cause));
        match (exactly, outside == unknown) {
            (true, true) => Self::Exact,
            (_, true) => Self::InSet,
            (_, false) => Self::Partly,
        }
    }
}
