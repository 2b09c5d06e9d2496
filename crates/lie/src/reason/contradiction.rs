//! Statements that exclude each other.

/// Two statements that exclude each other. Whoever sees one has found an error of this library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not decided because two statements contradict each other: {first}, but {second}; please report this model")]
pub struct Contradiction {
    /// One statement.
    pub first: String,
    /// The other.
    pub second: String,
}
