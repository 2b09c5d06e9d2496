//! Pages that need no network and no other file: one frame, and the pieces that they are made of.

mod equations;
mod figure;
mod page;

use std::fmt::Write as _;

use bracketry_symbolic::Notation;

pub use equations::equations;
pub use figure::{Figure, animation, figures, folded_figures, gallery};
pub use page::{Chapter, Page};

/// Text in which no sign has a meaning of its own in HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The name of a state, input, or parameter, set.
pub fn symbol(name: &str) -> String {
    Notation::symbol(name).mathml()
}

/// A paragraph of plain text.
pub fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

/// Paragraphs of a text that is broken into lines; an empty line ends one.
pub fn paragraphs(text: &str) -> String {
    text.split("\n\n")
        .map(|part| part.split_whitespace().collect::<Vec<_>>().join(" "))
        .map(|part| paragraph(&part))
        .collect()
}

/// Items of plain text; nothing without any.
pub fn list<S: AsRef<str>>(items: impl IntoIterator<Item = S>) -> String {
    items_of(items.into_iter().map(|item| escaped(item.as_ref())))
}

/// Items that are HTML already; nothing without any.
fn items_of(items: impl IntoIterator<Item = String>) -> String {
    let items: Vec<String> = items.into_iter().collect();
    if items.is_empty() { String::new() } else { format!("<ul><li>{}</li></ul>\n", items.join("</li><li>")) }
}

/// Content that is folded under a line.
pub fn folded(line: &str, content: &str) -> String {
    details("", line, content)
}

fn details(attributes: &str, line: &str, content: &str) -> String {
    format!("<details{attributes}><summary>{}</summary>\n{content}</details>\n", escaped(line))
}

/// A report for terminals as it stands, folded under a line.
pub fn verbatim(line: &str, text: &str) -> String {
    folded(line, &preformatted(line, text))
}

/// The same, open at first.
pub(crate) fn opened(line: &str, text: &str) -> String {
    details(" open", line, &preformatted(line, text))
}

fn preformatted(name: &str, text: &str) -> String {
    let name = escaped(name);
    format!("<pre tabindex=\"0\" role=\"region\" aria-label=\"{name}\">{}</pre>\n", escaped(text))
}

/// A row of cells, which are HTML already.
fn row<S: AsRef<str>>(tag: &str, cells: impl IntoIterator<Item = S>) -> String {
    let mut out = "<tr>".to_owned();
    for cell in cells {
        // A header without text is none.
        let (cell, tag) = (cell.as_ref(), if cell.as_ref().is_empty() { "td" } else { tag });
        let _ = write!(out, "<{tag}>{cell}</{tag}>");
    }
    out + "</tr>"
}

/// Content that scrolls by itself where it is wider than the page, with a name for those who do not see it.
pub fn wide(name: &str, content: &str) -> String {
    let name = escaped(name);
    format!("<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"{name}\">{content}</div>\n")
}

/// A table with a name for those who do not see it; header and cells are HTML already. Without a header where that is empty.
pub fn table(name: &str, header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut out = "<table>".to_owned();
    if !header.is_empty() {
        out += &row("th", header);
    }
    for cells in rows {
        out += &row("td", cells);
    }
    wide(name, &(out + "</table>"))
}

/// A table of names and what is said of them, in plain text.
pub fn facts<A: AsRef<str>, B: AsRef<str>>(name: &str, rows: impl IntoIterator<Item = (A, B)>) -> String {
    let rows = rows.into_iter().map(|(what, value)| vec![escaped(what.as_ref()), escaped(value.as_ref())]);
    table(name, &[], rows)
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
