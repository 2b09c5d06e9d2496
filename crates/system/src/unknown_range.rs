//! Why the set of values of a function is not known.

use bracketry_symbolic::Function;
use serde::{Serialize, Serializer};

/// Why the set of values of a function is not known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum UnknownRange {
    /// The search was given up.
    #[error("the function is too large")]
    TooLarge,
    /// No rule gives an interval.
    #[error("the values of {} are not a known interval", .0.text())]
    NoInterval(Function),
    /// Operands share inputs.
    #[error("the values of {} are not known", .0.text())]
    Shared(Function),
    /// A switching function's zeros are not known.
    #[error("where {} switches is not known", .0.text())]
    Switch(Function),
    /// The values have a gap.
    #[error("{} jumps over values", .0.text())]
    Gap(Function),
    /// The function has a free symbol.
    #[error("it depends on {0}")]
    Free(String),
    /// A constant has no value.
    #[error("{} has no value", .0.text())]
    NoValue(Function),
    /// A product of intervals has no value.
    #[error("a product has no value")]
    Product,
    /// A sum or product without terms.
    #[error("")]
    Empty,
}

impl Serialize for UnknownRange {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
