//! Lists in a line.

use std::fmt::Display;

/// The texts with something between them.
pub(super) fn joined(list: &[impl Display], between: &str) -> String {
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join(between)
}

/// The texts as a list in a sentence: "a", "a and b", "a, b, and c".
pub(super) fn series(list: &[impl Display]) -> String {
    match list {
        [] => String::new(),
        [one] => one.to_string(),
        [one, other] => format!("{one} and {other}"),
        [first @ .., last] => format!("{}, and {last}", joined(first, ", ")),
    }
}
