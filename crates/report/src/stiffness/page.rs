//! The stiffness of robots as pages.

use bracketry_stiffness::{ChosenPoses, CompensatedLog, Identification, Weighing};

use super::tables::{MATRIX, compliance, methods, springs, stiffness};
use super::{figures, text};
use crate::html::{self, Chapter, Figure, Page, escaped, folded, list, paragraph, table, verbatim};

/// The figures of an identification.
pub fn identification_figures(found: &Identification) -> Vec<Figure> {
    let springs = figures::stiffness(found);
    let springs =
        springs.map(|drawing| Figure::new("stiffness", "Stiffness of the joints with 95 % intervals", drawing));
    let residuals = figures::residuals(found);
    let residuals = residuals.map(|drawing| {
        let caption = "Residual of every measured translation, measured minus predicted";
        Figure::new("residuals", caption, drawing)
    });
    springs.into_iter().chain(residuals).collect()
}

/// The figures of a compensation.
pub fn compensation_figures(run: &CompensatedLog) -> Vec<Figure> {
    let caption = "Force, predicted displacement, and corrections over time";
    vec![Figure::new("compensation", caption, figures::compensated_log(run))]
}

/// An identification as an HTML page with these figures, and links to these files beside it.
pub fn identification_page(found: &Identification, figures: &[Figure], files: &[(String, String)]) -> String {
    let mut said: Vec<String> = found.advice.iter().map(text::advice).collect();
    let first = if said.is_empty() { "none; see the methods".to_owned() } else { said.remove(0) };
    let (picture, others) = figures.split_at(figures.len().min(1));
    let lead = verdict(&format!("Advice: {first}")) + &html::figures(picture);
    let mut notes = said;
    if !found.outliers.is_empty() {
        notes.push(format!("excluded as outliers: lines {}", text::listed(&found.outliers)));
    }
    notes.extend(found.outliers_kept.as_ref().map(|why| format!("no outliers excluded: {why}")));
    notes.extend(found.withheld.as_ref().map(|why| {
        format!("these springs are not written, and their intervals are not valid: {}", text::withheld(why))
    }));
    let mut chapters = Vec::new();
    if !notes.is_empty() {
        chapters.push(Chapter::new("Notes", list(&notes)));
    }
    chapters.push(Chapter::new("Methods", of_text("Methods", &methods(found).0, methods(found).1)));
    if !found.parameters.is_empty() {
        let (header, rows) = springs(found);
        let units = paragraph("Stiffness in N·m/rad, cubic stiffness in N·m/rad³, gap in rad, engaged in N·m.");
        chapters.push(Chapter::new("Joint springs", units + &of_text("Joint springs", &header, rows)));
    }
    let residual = found.residual.as_ref().map(|r| list(text::residual(r).lines())).unwrap_or_default();
    let residual = residual + &html::figures(others);
    if !residual.is_empty() {
        chapters.push(Chapter::new("Unexplained residual", residual));
    }
    if let Some(pose) = &found.cartesian {
        let matrices =
            [compliance(pose), stiffness(pose)].map(|m| folded(m.title, &of_text(m.title, &m.header, m.rows)));
        chapters.push(Chapter::new("At the tool point", paragraph(MATRIX) + &matrices.concat()));
    }
    let title = format!("Stiffness of {}: {} measurements", found.robot, found.measurements);
    written(title, lead, chapters, files)
}

/// A compensation along a log as an HTML page with these figures, and links to these files beside it.
pub fn compensation_page(run: &CompensatedLog, figures: &[Figure], files: &[(String, String)]) -> String {
    let said = text::compensated_log(run);
    let mut lines = said.lines();
    let lead = verdict(lines.next().unwrap_or_default()) + &html::figures(figures);
    let chapters = vec![Chapter::new("Results", list(lines))];
    written(format!("Compensation of {}", run.robot), lead, chapters, files)
}

/// Chosen measurements as an HTML page, with links to these files beside it.
pub fn poses_page(found: &ChosenPoses, files: &[(String, String)]) -> String {
    let said = text::chosen_poses(found);
    let lead = verdict(said.lines().next().unwrap_or_default());
    let rows = text::expected_errors(found).into_iter().map(Vec::from).collect();
    let errors = of_text("Expected errors", &["expected error", "of these", "of all"], rows);
    let known = if found.springs_known { String::new() } else { paragraph(text::NO_SPRINGS) };
    let lines = paragraph(&format!("Lines {} of the table.", text::listed(&found.lines)));
    let chapters = vec![Chapter::new("Expected errors", errors + &known), Chapter::new("Chosen measurements", lines)];
    written(format!("Measurements for {}", found.robot), lead, chapters, files)
}

/// A payload as an HTML page, with links to these files beside it.
pub fn weighing_page(found: &Weighing, files: &[(String, String)]) -> String {
    let said = text::weighing(found);
    let (results, toml) = said.split_once("\n\n").unwrap_or((&said, ""));
    let mut lines = results.lines();
    let lead = verdict(lines.next().unwrap_or_default()) + &list(lines);
    let chapters = vec![Chapter::new("In the robot file", verbatim("The table [payload]", toml))];
    written(format!("Payload of {}", found.robot), lead, chapters, files)
}

fn verdict(said: &str) -> String {
    format!("<p class=\"verdict\">{}.</p>\n", escaped(said))
}

fn of_text(name: &str, header: &[&str], rows: Vec<Vec<String>>) -> String {
    table(name, header, rows.into_iter().map(|row| row.iter().map(|cell| escaped(cell)).collect()))
}

fn written(title: String, lead: String, chapters: Vec<Chapter>, files: &[(String, String)]) -> String {
    let files = Chapter::files(files);
    Page::new(title, lead).chapters(chapters).chapters([files]).html()
}
