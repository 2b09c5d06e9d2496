//! Entries with named sections as text at any width, and as parts of a page of the documentation.

use std::fmt::Write as _;

use crate::analysis::summary::wrapped;

/// Columns before the text of a section.
const INDENT: usize = 12;
/// Columns of a line of a page.
const PAGE: usize = 150;
/// From a document to the root of the repository.
pub(crate) const ROOT: &str = "../";

/// A heading in lines of at most `width` characters.
pub(crate) fn heading(text: &str, width: usize) -> String {
    wrapped(text, width).join("\n") + "\n"
}

/// A word before paragraphs, in lines of at most `width` characters, except where a single word is longer.
pub(crate) fn section<T: AsRef<str>>(out: &mut String, word: &str, paragraphs: &[T], width: usize) {
    let room = width.saturating_sub(INDENT).max(1);
    let lines = paragraphs.iter().flat_map(|p| wrapped(p.as_ref(), room));
    for (k, line) in lines.enumerate() {
        let word = if k == 0 { word } else { "" };
        // Writing into a string cannot fail.
        let _ = writeln!(out, "  {word:<10}{line}");
    }
}

/// A text behind a head, further lines below its first.
pub(crate) fn hanging(out: &mut String, head: &str, text: &str, width: usize) {
    let indent = head.chars().count();
    for (k, line) in wrapped(text, width.saturating_sub(indent).max(1)).into_iter().enumerate() {
        let before = if k == 0 { head.to_owned() } else { " ".repeat(indent) };
        let _ = writeln!(out, "{before}{line}");
    }
}

/// The text with links in place of the paths of documents.
pub(crate) fn linked(text: &str) -> String {
    let (mut out, mut rest) = (String::new(), text);
    while let Some((before, (path, after))) =
        rest.split_once("docs/").and_then(|(before, from)| Some((before, from.split_once(".md")?)))
    {
        let _ = write!(out, "{before}[{path}.md]({path}.md)");
        rest = after;
    }
    out + rest
}

/// A text in the lines of a page.
pub(crate) fn paragraph(text: &str) -> String {
    wrapped(text, PAGE).join("\n") + "\n"
}

/// An item of a list on a page with its parts, each on a line of its own.
pub(crate) fn item(out: &mut String, word: &str, parts: impl Iterator<Item = String>) {
    let parts: Vec<String> = parts.collect();
    if !parts.is_empty() {
        let _ = writeln!(out, "- {word}: {}", parts.join(",\n  "));
    }
}

/// The anchor of a heading.
pub(crate) fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
    heading.to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")
}
