//! The rows as text at any width, and as the page of the documentation.

use std::fmt::Write as _;

use super::{Field, Ours, Row, rows};
use crate::paragraphs::{anchor, hanging, heading, item, linked, paragraph, section};

/// A row in lines of at most `width` characters, except where a single word is longer.
pub fn row_text(row: &Row, width: usize) -> String {
    let mut out = heading(&row.heading(), width);
    section(&mut out, "reference", &[row.reference], width);
    section(&mut out, "claim", &[row.claim], width);
    section(&mut out, "command", &[row.command()], width);
    section(&mut out, "ours", &row.figure(), width);
    section(&mut out, "tests", row.tests, width);
    section(&mut out, "verdict", &[row.verdict.to_string().as_str(), row.remark], width);
    out
}

/// A line for each of some rows: name, verdict, reference, and subject.
pub fn list_text<'a>(list: impl IntoIterator<Item = &'a Row>, width: usize) -> String {
    let mut out = String::new();
    for row in list {
        let head = format!("{:<26}  {:<7}  ", row.name, row.verdict);
        hanging(&mut out, &head, &format!("{}: {}", row.reference, row.subject), width);
    }
    out
}

/// The rows as Markdown for a document in `docs`: a table, then a section for each row.
pub fn page() -> String {
    let mut out = "| name | reference | about | verdict |\n|---|---|---|---|\n".to_owned();
    for row in rows() {
        let (name, at, reference) = (row.name, anchor(&row.heading()), row.reference);
        // Writing into a string cannot fail.
        let _ = writeln!(out, "| [{name}](#{at}) | {reference} | {} | {} |", row.subject, row.verdict);
    }
    for field in Field::ALL {
        let _ = write!(out, "\n## {field}\n");
        rows().filter(|row| row.field == field).for_each(|row| entry(&mut out, row));
    }
    out
}

/// The section of a row.
fn entry(out: &mut String, row: &Row) {
    let claim = format!("{}: {}", row.reference, row.claim);
    let _ = write!(out, "\n### {}\n\n{}\n", row.heading(), paragraph(&claim));
    item(out, "Command", std::iter::once(format!("`{}`", row.command())));
    match row.ours {
        Ours::Printed { lines, .. } => item(out, "Prints", lines.iter().map(|line| format!("`{line}`"))),
        Ours::Asserted(text) => item(out, "Asserts", std::iter::once(text.to_owned())),
    }
    item(out, "Tests", row.tests.iter().map(|test| format!("`{test}`")));
    let verdict = format!("**Verdict: {}.** {}", row.verdict, linked(row.remark));
    let _ = write!(out, "\n{}", paragraph(&verdict));
}
