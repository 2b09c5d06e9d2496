//! What a report consists of, whatever it is written in.

/// A piece of running text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Span {
    /// Words.
    Text(String),
    /// A formula in LaTeX.
    Math(String),
    /// A name as it stands in files.
    Code(String),
}

/// Running text.
pub(super) type Line = Vec<Span>;

/// A part of a report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Block {
    /// Title of the report (level 1) or of a section (level 2).
    Heading(usize, String),
    /// A paragraph.
    Paragraph(Line),
    /// Items.
    List(Vec<Line>),
    /// Formulas below each other, aligned at `&`.
    Display(Vec<String>),
    /// Header and rows.
    Table(Vec<Line>, Vec<Vec<Line>>),
}

pub(super) fn text(words: impl Into<String>) -> Span {
    Span::Text(words.into())
}

pub(super) fn math(formula: impl Into<String>) -> Span {
    Span::Math(formula.into())
}

pub(super) fn code(name: impl Into<String>) -> Span {
    Span::Code(name.into())
}

/// A paragraph of words alone.
pub(super) fn words(words: impl Into<String>) -> Block {
    Block::Paragraph(vec![text(words)])
}

/// Starts a section.
pub(super) fn section(out: &mut Vec<Block>, title: &str) {
    out.push(Block::Heading(2, title.to_owned()));
}

/// `name: value` as an item.
pub(super) fn item(name: &str, value: impl Into<String>) -> Line {
    vec![text(format!("{name}: {}", value.into()))]
}
