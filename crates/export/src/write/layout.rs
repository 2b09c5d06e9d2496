//! Lists over several lines.

use crate::equations::ExportedResult;

/// Longer lists have one entry a line.
const WIDTH: usize = 100;

/// `[a, b]`, or over several lines that begin with `indent`.
pub(crate) fn list([open, close]: [&str; 2], entries: &[String], indent: &str) -> String {
    let line = entries.join(", ");
    if indent.len() + open.len() + line.len() + close.len() <= WIDTH {
        return format!("{open}{line}{close}");
    }
    block([open, close], entries, indent)
}

/// The same with one entry a line, however few there are.
pub(crate) fn block([open, close]: [&str; 2], entries: &[String], indent: &str) -> String {
    let mut lines = String::new();
    for entry in entries {
        lines.extend([indent, "    ", entry, ",\n"]);
    }
    format!("{open}\n{lines}{indent}{close}")
}

/// The rows of a matrix, each as a list; `indent` is that of the matrix.
pub(crate) fn rows(brackets: [&str; 2], result: &ExportedResult, entries: &[String], indent: &str) -> Vec<String> {
    let columns = result.columns.unwrap_or(1);
    let deeper = format!("{indent}    ");
    (0..result.rows).map(|i| list(brackets, &entries[i * columns..(i + 1) * columns], &deeper)).collect()
}
