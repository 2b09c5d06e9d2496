//! The entries as text at any width, and as the page of the documentation.

use std::fmt::Write as _;

use super::{Entry, entries};
use crate::paragraphs::{ROOT, anchor, hanging, heading, item, linked, paragraph, section};

/// An entry in lines of at most `width` characters, except where a single word is longer.
pub fn entry_text(entry: &Entry, width: usize) -> String {
    let mut out = heading(&entry.heading(), width);
    section(&mut out, "statement", &[entry.statement], width);
    let places: Vec<String> = entry.places.iter().map(|p| format!("{} ({})", p.name, p.file)).collect();
    section(&mut out, "here", &places, width);
    section(&mut out, "tests", entry.tests, width);
    section(&mut out, "commands", entry.commands, width);
    section(&mut out, "verdict", &[entry.verdict.to_string().as_str(), entry.remark], width);
    out
}

/// A line for each of some entries: label, verdict, and title.
pub fn list_text<'a>(list: impl IntoIterator<Item = &'a Entry>, width: usize) -> String {
    let mut out = String::new();
    for entry in list {
        hanging(&mut out, &format!("{:<15}  {:<9}  ", entry.label(), entry.verdict), entry.title, width);
    }
    out
}

/// The entries as Markdown for a document in `docs`: a table of verdicts, then a section for each.
pub fn page() -> String {
    let mut out = "| | verdict | about |\n|---|---|---|\n".to_owned();
    for entry in entries() {
        let (label, anchor, verdict, title) = (entry.label(), anchor(&entry.heading()), entry.verdict, entry.title);
        // Writing into a string cannot fail.
        let _ = writeln!(out, "| [{label}](#{anchor}) | {verdict} | {title} |");
    }
    for entry in entries() {
        let _ = write!(out, "\n### {}\n\n{}\n", entry.heading(), paragraph(entry.statement));
        item(&mut out, "Here", entry.places.iter().map(|p| format!("[`{}`]({ROOT}{})", p.name, p.file)));
        item(&mut out, "Tests", entry.tests.iter().map(|test| format!("`{test}`")));
        item(&mut out, "Commands", entry.commands.iter().map(|command| format!("`{command}`")));
        let _ = write!(out, "\n{}", paragraph(&format!("**Verdict: {}.** {}", entry.verdict, linked(entry.remark))));
    }
    out
}
