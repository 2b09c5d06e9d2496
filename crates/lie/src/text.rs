//! Parts of lines.

use crate::named::Named;

/// Longer lines are left to the machine-readable report.
const MAX_LINE: usize = 240;

/// The text, unless it makes no readable line.
pub(crate) fn readable(text: &str) -> String {
    if text.chars().count() <= MAX_LINE { text.to_owned() } else { "(long; see the JSON report)".to_owned() }
}

/// `a = …, b = …`
pub(crate) fn assignments(list: &Named<String>, mark: &str) -> String {
    list.0.iter().map(|(name, e)| format!("{name}{mark} = {e}")).collect::<Vec<_>>().join(", ")
}
