//! The entries as text at any width, and as the page of the documentation.

use std::fmt::Write as _;

use super::{Entry, entries};
use crate::analysis::summary::wrapped;

/// Columns before the text of an entry.
const INDENT: usize = 12;
/// Columns of a line of the page.
const PAGE: usize = 150;
/// From a document to the root of the repository.
const ROOT: &str = "../";

/// An entry in lines of at most `width` characters, except where a single word is longer.
pub fn entry_text(entry: &Entry, width: usize) -> String {
    let mut out: String = wrapped(&entry.heading(), width).join("\n") + "\n";
    section(&mut out, "statement", &[entry.statement], width);
    let places: Vec<String> = entry.places.iter().map(|p| format!("{} ({})", p.name, p.file)).collect();
    section(&mut out, "here", &places, width);
    section(&mut out, "tests", entry.tests, width);
    section(&mut out, "commands", entry.commands, width);
    section(&mut out, "verdict", &[entry.verdict.to_string().as_str(), entry.remark], width);
    out
}

/// A word before paragraphs.
fn section<T: AsRef<str>>(out: &mut String, word: &str, paragraphs: &[T], width: usize) {
    let room = width.saturating_sub(INDENT).max(1);
    let lines = paragraphs.iter().flat_map(|p| wrapped(p.as_ref(), room));
    for (k, line) in lines.enumerate() {
        let word = if k == 0 { word } else { "" };
        // Writing into a string cannot fail.
        let _ = writeln!(out, "  {word:<10}{line}");
    }
}

/// A line for each of some entries: label, verdict, and title.
pub fn list_text<'a>(list: impl IntoIterator<Item = &'a Entry>, width: usize) -> String {
    let mut out = String::new();
    for entry in list {
        let head = format!("{:<15}  {:<9}  ", entry.label(), entry.verdict);
        let indent = head.chars().count();
        for (k, line) in wrapped(entry.title, width.saturating_sub(indent).max(1)).into_iter().enumerate() {
            let before = if k == 0 { head.clone() } else { " ".repeat(indent) };
            let _ = writeln!(out, "{before}{line}");
        }
    }
    out
}

/// The entries as Markdown for a document in `docs`: a table of verdicts, then a section for each.
pub fn page() -> String {
    let mut out = "| | verdict | about |\n|---|---|---|\n".to_owned();
    for entry in entries() {
        let (label, anchor, verdict, title) = (entry.label(), anchor(entry), entry.verdict, entry.title);
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

/// The text with links in place of the paths of documents.
fn linked(text: &str) -> String {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, (path, after))) =
        rest.split_once("docs/").and_then(|(before, from)| Some((before, from.split_once(".md")?)))
    {
        let _ = write!(out, "{before}[{path}.md]({path}.md)");
        rest = after;
    }
    out + rest
}

/// A text in lines.
fn paragraph(text: &str) -> String {
    wrapped(text, PAGE).join("\n") + "\n"
}

/// An item of a list with its parts, each on a line of its own.
fn item(out: &mut String, word: &str, parts: impl Iterator<Item = String>) {
    let parts: Vec<String> = parts.collect();
    if !parts.is_empty() {
        let _ = writeln!(out, "- {word}: {}", parts.join(",\n  "));
    }
}

/// The anchor of the heading of an entry.
fn anchor(entry: &Entry) -> String {
    let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
    entry.heading().to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")
}
