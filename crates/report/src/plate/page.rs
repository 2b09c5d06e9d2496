//! A run on the plate as a page.

use bracketry_plate::PlateExperiment;

use super::text::{assumption, compared, headline, result, setup, target};
use crate::html::{self, Chapter, Figure, Page, escaped, facts, list, verbatim};

/// A run as an HTML page with these figures, an animation as HTML if there is one, and links to these files beside it.
pub fn page(ran: &PlateExperiment, figures: &[Figure], animation: Option<&str>, files: &[(String, String)]) -> String {
    let (first, others) = figures.split_at(figures.len().min(1));
    let lead = format!("<p class=\"verdict\">Target: {}.</p>\n", escaped(&target(ran))) + &html::figures(first);
    let mut chapters = vec![Chapter::new("Results", facts("Results", result(ran)))];
    let seen = animation.unwrap_or_default().to_owned() + &html::figures(others);
    if !seen.is_empty() {
        chapters.push(Chapter::new("Seen from above", seen));
    }
    let compared = compared(ran);
    if !compared.is_empty() {
        chapters.push(Chapter::new("Compared with the log", verbatim("How run and log agree", &compared)));
    }
    chapters.push(Chapter::new("What was simulated", facts("What was simulated", setup(ran))));
    chapters.push(Chapter::new("Assumptions", list(ran.assumptions().into_iter().map(assumption))));
    chapters.push(Chapter::files(files));
    Page::new(headline(ran), lead).chapters(chapters).html()
}
