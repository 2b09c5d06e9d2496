//! The frame of a page: headline, contents, chapters.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fmt::Write as _;
use std::path::Path;

use bracketry_system::System;

use super::equations::model;
use super::figure::Figure;
use super::{escaped, folded, items_of, opened};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = concat!(include_str!("figure.js"), include_str!("page.js"));
/// Files of figures from which on they are folded.
const FEW_FIGURES: usize = 5;
/// Levels of headings below the title that the contents list.
const LISTED: usize = 2;

/// A part of a page with a heading.
#[derive(Clone, Debug, Default)]
pub struct Chapter {
    title: String,
    body: String,
    parts: Vec<Chapter>,
}

impl Chapter {
    /// A chapter with this heading in plain text and this content, which is HTML already.
    pub fn new(title: impl Into<String>, body: impl Into<String>) -> Self {
        Self { title: title.into(), body: body.into(), parts: Vec::new() }
    }

    /// Adds chapters one level below.
    #[must_use]
    pub fn parts(mut self, parts: impl IntoIterator<Item = Chapter>) -> Self {
        self.parts.extend(parts);
        self
    }

    /// Equations, parameters, and outputs of a model.
    pub fn model(title: &str, system: &System) -> Self {
        Self::new(title, model(system))
    }

    /// Links to files that lie beside the page; a file is its name and what is in it. Many figures are folded.
    pub fn files(files: &[(String, String)]) -> Self {
        let list = |files: Vec<&(String, String)>| {
            let item = |(name, what): &(String, String)| {
                let (name, what) = (escaped(name), escaped(what));
                format!("<a href=\"{name}\">{name}</a>: {what}")
            };
            items_of(files.into_iter().map(item))
        };
        let ending = |name: &str| Path::new(name).extension().map(OsStr::to_os_string);
        let is_figure = |(name, _): &&(String, String)| ending(name).is_some_and(|e| e == "svg" || e == "png");
        let (figures, others): (Vec<_>, Vec<_>) = files.iter().partition(is_figure);
        if figures.len() < FEW_FIGURES || others.is_empty() {
            return Self::new("Files", list(files.iter().collect()));
        }
        Self::new("Files", list(others) + &folded("The figures as SVG and PNG", &list(figures)))
    }
}

/// A page.
#[derive(Clone, Debug, Default)]
pub struct Page {
    title: String,
    lead: String,
    chapters: Vec<Chapter>,
}

impl Page {
    /// A page with this title in plain text, and what stands below it before all chapters: the answer and the first figure, as HTML.
    pub fn new(title: impl Into<String>, lead: impl Into<String>) -> Self {
        Self { title: title.into(), lead: lead.into(), chapters: Vec::new() }
    }

    /// Adds chapters.
    #[must_use]
    pub fn chapters(mut self, chapters: impl IntoIterator<Item = Chapter>) -> Self {
        self.chapters.extend(chapters);
        self
    }

    /// A page of a report as text: its first line in front, then these figures, the report as it stands, the model, and links to
    /// files beside it.
    pub fn of_text(title: &str, said: &str, figures: &[Figure], system: &System, files: &[(String, String)]) -> String {
        let first = said.lines().next().unwrap_or_default();
        let lead = format!("<p class=\"verdict\">{}.</p>\n", escaped(first)) + &super::figures(figures);
        let chapters = [
            Chapter::new("The report", opened("As the command prints it", said)),
            Chapter::model("Model", system),
            Chapter::files(files),
        ];
        Self::new(title, lead).chapters(chapters).html()
    }

    /// The page as HTML.
    pub fn html(&self) -> String {
        let title = escaped(&self.title);
        let (mut contents, mut body, mut known) = (String::new(), String::new(), BTreeSet::new());
        written(&self.chapters, 1, &mut known, &mut contents, &mut body);
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\
             <meta name=\"color-scheme\" content=\"light dark\"/><title>{title}</title>\n<style>\n{STYLE}</style></head><body>\n\
             <nav aria-label=\"Contents\"><details open><summary>Contents</summary>{contents}</details></nav>\n\
             <main><h1>{title}</h1>\n<div class=\"lead\">\n{}</div>\n{body}</main>\n<script>\n{SCRIPT}</script></body></html>\n",
            self.lead
        )
    }
}

/// Writes chapters of a level with their headings, and lists these.
fn written(chapters: &[Chapter], level: usize, known: &mut BTreeSet<String>, contents: &mut String, body: &mut String) {
    let listed = level <= LISTED && !chapters.is_empty();
    contents.push_str(if listed { "<ol>" } else { "" });
    for chapter in chapters {
        let (title, id) = (escaped(&chapter.title), free_id(&chapter.title, known));
        // HTML has headings down to level 6.
        let heading = (level + 1).min(6);
        let _ = writeln!(body, "<h{heading} id=\"{id}\">{title}</h{heading}>\n{}", chapter.body);
        if listed {
            let _ = write!(contents, "<li><a href=\"#{id}\">{title}</a>");
        }
        written(&chapter.parts, level + 1, known, contents, body);
        contents.push_str(if listed { "</li>" } else { "" });
    }
    contents.push_str(if listed { "</ol>" } else { "" });
}

/// An id made of the letters of a title that no other heading has.
fn free_id(title: &str, known: &mut BTreeSet<String>) -> String {
    let words = title.to_lowercase();
    let words: Vec<&str> = words.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty()).collect();
    let name = format!("s-{}", words.join("-"));
    let mut id = name.clone();
    let mut count = 1;
    while !known.insert(id.clone()) {
        count += 1;
        id = format!("{name}-{count}");
    }
    id
}
