//! A value, or the reason why there is none.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::reason::Reason;

/// What an analysis found out. Serialized as the value, or as the string `"unknown"`; reports
/// carry the reason beside it.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer<T> {
    /// Decided.
    Known(T),
    /// Not decided, with the reason.
    Unknown(Reason),
}

impl<T: Default> Default for Answer<T> {
    fn default() -> Self {
        Answer::Known(T::default())
    }
}

impl<T> Answer<T> {
    /// The value if there is one.
    pub fn known(&self) -> Option<&T> {
        match self {
            Answer::Known(v) => Some(v),
            Answer::Unknown(_) => None,
        }
    }

    /// The answer with another value.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Answer<U> {
        match self {
            Answer::Known(v) => Answer::Known(f(v)),
            Answer::Unknown(why) => Answer::Unknown(why),
        }
    }

    /// The reason if there is no value.
    pub fn reason(&self) -> Option<&Reason> {
        match self {
            Answer::Known(_) => None,
            Answer::Unknown(r) => Some(r),
        }
    }
}

impl<T, E: Into<Reason>> From<Result<T, E>> for Answer<T> {
    fn from(r: Result<T, E>) -> Self {
        match r {
            Ok(v) => Answer::Known(v),
            Err(e) => Answer::Unknown(e.into()),
        }
    }
}

impl<T: Serialize> Serialize for Answer<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Answer::Known(v) => v.serialize(serializer),
            Answer::Unknown(_) => serializer.serialize_str("unknown"),
        }
    }
}

impl<T: fmt::Display> fmt::Display for Answer<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Answer::Known(v) => v.fmt(f),
            Answer::Unknown(r) => write!(f, "unknown ({r})"),
        }
    }
}
