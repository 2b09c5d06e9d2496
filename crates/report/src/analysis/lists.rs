//! Lists in a line.

use std::fmt::Display;

/// The texts with something between them.
pub(super) fn joined(list: &[impl Display], between: &str) -> String {
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join(between)
}
