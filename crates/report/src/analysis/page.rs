//! An analysis as a page.

use bracketry_lie::analysis::Dimensions;
use bracketry_lie::{Analysis, Answer};

use super::affinization::changes;
use super::figures::{growth_figure, reach_figure};
use super::summary::{summary, verdict};
use super::text::{family, outputs_tell, point_facts, text};
use crate::html::{self, Chapter, Figure, Page, equations, escaped, facts, folded, list, paragraph, table, verbatim};

/// The figures of an analysis; what the inputs influence only where the analysis could tell.
pub fn figures(a: &Analysis) -> Vec<Figure> {
    let growth =
        Figure::new("growth", "Directions spanned by the brackets, by bracket length", growth_figure(a).draw());
    let caption = "Influence of the inputs on the states, by round of brackets";
    let reach = reach_figure(a).map(|chart| Figure::new("reach", caption, chart.draw()));
    std::iter::once(growth).chain(reach).collect()
}

/// An analysis as an HTML page with these figures, and links to these files beside it.
pub fn page(a: &Analysis, figures: &[Figure], files: &[(String, String)]) -> String {
    let (first, others) = figures.split_at(figures.len().min(1));
    let lead = format!("<p class=\"verdict\">{}</p>\n", escaped(&verdict(a))) + &html::figures(first);
    let mut chapters =
        vec![Chapter::new("What the inputs reach", paragraph(&summary(a)) + &dimensions(a) + &html::figures(others))];
    if let Some(Answer::Known(point)) = &a.report.at_point {
        chapters.push(Chapter::new("At the point", facts("At the point", point_facts(point))));
    }
    if let Some(outputs) = &a.report.observability {
        let rank = paragraph(&format!("Observability rank: {}.", outputs.rank));
        chapters.push(Chapter::new("What the outputs tell", rank + &list(outputs_tell(outputs))));
    }
    chapters.extend([
        Chapter::new(
            "The whole report",
            verbatim("Ranks, brackets, and verdicts, as the command prints them", &text(a)),
        ),
        Chapter::model("Model", &a.original),
        affine_form(a),
        Chapter::files(files),
    ]);
    Page::new(format!("Analysis of {}", a.model), lead).chapters(chapters).html()
}

/// A table of the dimensions of what is reached, in every mode and over all of them, as HTML.
pub fn dimensions(a: &Analysis) -> String {
    let report = &a.report;
    let mut rows = Vec::new();
    let mut add = |what: String, d: &Dimensions| {
        let growth = |steps: &[usize]| steps.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let (up_to, at) = (&d.accessible_dimension, &d.strongly_accessible_dimension);
        let cells = [what, up_to.to_string(), growth(&d.growth), at.to_string(), growth(&d.strong_growth)];
        rows.push(cells.map(|cell| escaped(&cell)).to_vec());
    };
    for mode in &report.modes {
        let is_generic = mode.signs.0.is_empty();
        let what =
            if is_generic { "at a generic point".to_owned() } else { format!("while {}", mode.signs.condition()) };
        add(what, &mode.dimensions);
    }
    if let Some(switched) = &report.switched {
        add("all modes together".to_owned(), &switched.dimensions);
    }
    if let Some(smoothed) = &report.smoothed {
        add(format!("smoothed, width {}", smoothed.epsilon), &smoothed.dimensions);
    }
    if let Some(point) = report.at_point.as_ref().and_then(|p| p.known()) {
        add("at the point".to_owned(), &point.dimensions);
    }
    let header = ["", "accessible", "growth", "strongly accessible", "growth"];
    paragraph(&format!(
        "Dimension of the set that is reached up to some time (accessible) and at a given time (strongly accessible), out of {}; the \
         growth gives the dimension after each round of brackets.",
        a.states
    )) + &table("Dimensions", &header, rows)
}

/// How the model became affine in its inputs.
fn affine_form(a: &Analysis) -> Chapter {
    let affine = &a.affinization.system;
    let mut said = changes(&a.affinization);
    said.extend(a.family.as_ref().map(family));
    said.extend(affine.eliminated.iter().map(ToString::to_string));
    let mut out = paragraph(&format!("Affine form: {}.", a.affinization.why)) + &list(&said);
    if !a.affine {
        out += &folded("The equations that are affine in the inputs", &equations(affine));
    }
    Chapter::new("Affine form", out)
}
