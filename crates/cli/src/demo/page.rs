//! The story as one page that needs nothing else.

use std::collections::BTreeMap;

use super::figures::MAP;
use super::on_plant::MoveOnPlant;
use super::story::{Story, StoryAnimation};
use super::text::{self, LOOPS, METHODS};
use bracketry::report::Figure;
use bracketry::report::analysis::dimensions;
use bracketry::report::from_rest::from_rest_map_text;
use bracketry::report::html::{
    self, Chapter, Page, equations, escaped, folded, paragraph, paragraphs, table, verbatim,
};

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
    /// The story as an HTML page with figures, tables, formulas and these animations, and links to these files beside it; it needs no
    /// network and no other file.
    pub fn page(&self, animations: &[StoryAnimation], files: &[String]) -> String {
        let mut figures = self.chapters();
        let captions: BTreeMap<String, String> =
            figures.iter().flatten().map(|f| (f.name.clone(), f.caption.clone())).collect();
        // What it comes to: both models on the true plant.
        let first = [5, 2].into_iter().find_map(|k: usize| figures[k].pop());
        let lead = format!("<p class=\"verdict\">{}</p>\n", escaped(&self.verdict()))
            + &html::figures(&first)
            + &self.table()
            + &paragraphs(text::OPENING);
        let film = |chapter: usize| -> String {
            let films = animations.iter().filter(|a| a.chapter == chapter);
            films.map(|a| html::animation(&a.gif, &a.still, &format!("{}, in real time.", a.title))).collect()
        };
        let whole = |chapter: usize| format!("Everything that the command prints of chapter {chapter}");
        let drawn = |k: usize| html::folded_figures(&figures[k]);
        let moved = |chapter: usize, moved: &MoveOnPlant| {
            paragraph(&moved.outcome())
                + &of_rows(&format!("Final errors, {}", moved.model), LOOPS, moved.errors())
                + &film(chapter)
                + &drawn(chapter - 1)
                + &verbatim(&whole(chapter), &moved.to_string())
        };
        let m = &self.on_equations;
        let second =
            of_rows("Final errors", METHODS, m.errors()) + &film(2) + &drawn(1) + &verbatim(&whole(2), &m.to_string());
        let ranks = text::of_ranks(self.diagnosis.ranks.as_ref(), self.diagnosis.report.evidence.model.is_some());
        let sixth = match &self.extended {
            Some(extended) => moved(6, extended),
            None => paragraph("There is no extended model."),
        };
        let contents = [
            String::new(),
            second,
            moved(3, &self.as_published),
            verbatim("The logs", &text::of_logs(&self.logs)) + &self.diagnosis.verdict(),
            html::gallery(&figures[4]) + &verbatim(&whole(5), &ranks),
            sixth,
        ];
        let titles = [text::FIRST, text::SECOND, text::THIRD, text::FOURTH, text::FIFTH, text::SIXTH];
        let chapters = contents.into_iter().enumerate().map(|(k, content)| {
            let chapter = Chapter::new(titles[k].trim_end(), paragraph(OPENINGS[k]) + &content);
            match k {
                0 => chapter.parts(self.first(&figures[0])),
                3 => chapter.parts(self.diagnosis.chapters(&figures[3])),
                _ => chapter,
            }
        });
        let files = (!files.is_empty()).then(|| {
            let files: Vec<_> = files.iter().map(|name| (name.clone(), what(name, &captions))).collect();
            Chapter::files(&files)
        });
        Page::new(self.title(), lead).chapters(chapters).chapters(files).html()
    }

    fn first(&self, figures: &[Figure]) -> [Chapter; 4] {
        let affine = &self.analysis.affinization.system;
        let (map, others): (Vec<&Figure>, Vec<_>) = figures.iter().partition(|f| f.name == MAP);
        let said = bracketry::report::analysis::text(&self.analysis);
        let reach = dimensions(&self.analysis)
            + &html::folded_figures(others)
            + &verbatim("Everything that the analysis says", &said);
        let rest = paragraph(
            "At rest, dry friction balances small inputs. A coordinate changes only if inputs within the bounds lead out of the friction \
             cone, and then loops of the inputs move it both ways.",
        ) + &html::figures(map)
            + &verbatim("Where the answers change", &from_rest_map_text(&self.from_rest));
        [
            Chapter::new("The published equations", equations(&self.published)),
            Chapter::new(
                "Affine in its inputs",
                folded("The equations with integrators in front of the inputs", &equations(affine)),
            ),
            Chapter::new("What the inputs reach", reach),
            Chapter::new("What changes from rest to rest", rest),
        ]
    }

    fn table(&self) -> String {
        of_rows(
            "On the true plant, with each model in the controller",
            ["", "published model", "extended model"],
            self.comparison(),
        )
    }
}

/// A table of plain text.
fn of_rows<const N: usize>(name: &str, header: [&str; N], rows: impl IntoIterator<Item = [String; N]>) -> String {
    table(name, &header, rows.into_iter().map(|row| row.map(|cell| escaped(&cell)).to_vec()))
}

/// What is in a file of the command: the caption of a figure, else by its ending.
fn what(name: &str, captions: &BTreeMap<String, String>) -> String {
    let (stem, ending) = name.rsplit_once('.').unwrap_or((name, ""));
    let what = match ending {
        "csv" => "a log or a trajectory",
        "svg" | "png" => captions.get(stem).map_or("a figure", |caption| caption.trim_end_matches('.')),
        "gif" => "an animation",
        "toml" => "a model",
        "json" => "results for programs",
        _ => "a report as text",
    };
    what.to_owned()
}
