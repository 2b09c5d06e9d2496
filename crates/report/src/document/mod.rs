//! The analysis as a document: sections of text, formulas and tables, written as Markdown or LaTeX.

mod blocks;
mod control;
mod formulas;
mod latex;
mod local;
mod markdown;
mod outputs;
mod sections;

use crate::Analysis;

impl Analysis {
    /// The report as Markdown with LaTeX formulas between dollar signs.
    pub fn markdown(&self) -> String {
        markdown::written(&sections::document(self))
    }

    /// The report as a LaTeX document of its own.
    pub fn latex(&self) -> String {
        latex::written(&sections::document(self))
    }
}
