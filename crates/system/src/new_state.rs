//! New states in place of old ones.

use bracketry_symbolic::Function;
use serde::{Serialize, Serializer};

/// A new state z = T(x, u, …) in place of an old one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NewState {
    /// Its name.
    pub name: String,
    /// The old state whose place it takes.
    pub replaces: String,
    /// T
    #[serde(serialize_with = "whole")]
    pub function: Function,
    /// The old state as a function of the new ones.
    #[serde(serialize_with = "whole")]
    pub inverse: Function,
}

/// A function's text, however long.
fn whole<S: Serializer>(function: &Function, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&function.text())
}
