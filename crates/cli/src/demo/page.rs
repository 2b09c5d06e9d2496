//! The story as one page that needs nothing else.

use std::fmt::Write as _;

use super::story::{Story, StoryAnimation};
use super::text;
use bracketry::report::from_rest::from_rest_map_text;
use bracketry::report::html::{self, equations, escaped, heading, paragraph, table, verbatim};

/// What each chapter does, in a sentence.
const OPENINGS: [&str; 6] = [
    "The published model of the vibrating plate, as printed: an object on a plate that shakes along x and tilts about the \
     same axis. It is not affine in its two inputs; Lie brackets of its affine form determine what the inputs reach.",
    "A model-predictive controller plans the move of position and orientation together, in little more than the shortest time, and \
     corrects it every 20 ms. It sees what a camera measures, one sample late. Its plant here is the published model's own equations, \
     with set-valued dry friction: sliding and sticking are located as events.",
    "The true plant is a simulation of contact over the whole footprint: each point of it carries its share of the load and slides or sticks in \
     its own direction. The controller still predicts with the published model.",
    "A laboratory would record this run and a few more experiments: logs at 200 Hz of the commanded motion and the \
     measured pose, with noise. The diagnosis sees these columns and the published model, and nothing else. The last log is \
     held out: it is not used for fitting.",
    "The equations now contain the terms found by the diagnosis; the same analysis shows their effect.",
    "The same controller uses the extended model on the same plant.",
];

impl Story {
    /// The story as an HTML page with figures, tables, formulas and these animations; it needs no network and no other file.
    pub fn page(&self, animations: &[StoryAnimation]) -> String {
        let mut body = heading(1, self.title());
        body += &paragraph(text::OPENING.trim_end());
        let _ = writeln!(body, "<p class=\"verdict\">{}</p>", escaped(&self.verdict()));
        body += &paragraph("On the true plant, with each model in the controller:");
        body += &self.table();
        let figures = self.chapters();
        let contents = [
            self.first(),
            verbatim(&self.on_equations.to_string()),
            verbatim(&self.as_published.to_string()),
            verbatim(&text::of_logs(&self.logs)) + &self.diagnosis.section(&figures[3], 3),
            verbatim(&text::of_ranks(self.diagnosis.ranks.as_ref(), self.diagnosis.report.evidence.model.is_some())),
            self.extended.as_ref().map_or_else(
                || paragraph("There is no extended model."),
                |moved| verbatim(&moved.to_string()) + &self.table(),
            ),
        ];
        let titles = [text::FIRST, text::SECOND, text::THIRD, text::FOURTH, text::FIFTH, text::SIXTH];
        for (k, content) in contents.into_iter().enumerate() {
            body += &heading(2, titles[k].trim_end());
            body += &paragraph(OPENINGS[k]);
            body += &content;
            for film in animations.iter().filter(|a| a.chapter == k + 1) {
                body += &html::animation(&film.gif, &format!("{}, in real time.", film.title));
            }
            if k != 3 {
                body += &html::figures(&figures[k]);
            }
        }
        html::page(self.title(), &body)
    }

    fn first(&self) -> String {
        let affine = &self.analysis.affinization.system;
        heading(3, "The published equations")
            + &equations(&self.published)
            + &heading(3, "Affine in its inputs")
            + &equations(affine)
            + &heading(3, "What the inputs reach")
            + &verbatim(&bracketry::report::analysis::text(&self.analysis))
            + &heading(3, "What changes from rest to rest")
            + &paragraph(
                "At rest, dry friction balances small inputs. A coordinate changes only if inputs within the bounds lead out of the friction \
                 cone, and then loops of the inputs move it both ways.",
            )
            + &verbatim(&from_rest_map_text(&self.from_rest))
    }

    fn table(&self) -> String {
        let rows = self.comparison().into_iter().map(|row| row.map(|cell| escaped(&cell)).to_vec());
        table(&["", "published model", "extended model"], rows)
    }
}
