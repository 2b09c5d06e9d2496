//! The analysis as a document: sections of text, formulas and tables, written as Markdown or LaTeX.

mod blocks;
mod control;
mod formulas;
mod latex;
mod local;
mod markdown;
mod outputs;
mod sections;

use bracketry_lie::Analysis;

/// The report as Markdown with LaTeX formulas between dollar signs.
pub fn markdown(analysis: &Analysis) -> String {
    markdown::written(&sections::document(analysis))
}

/// The report as a LaTeX document of its own.
pub fn latex(analysis: &Analysis) -> String {
    latex::written(&sections::document(analysis))
}
