//! The report as one page that needs nothing else: text, tables, formulas and figures.

use std::fmt::Write as _;

use bracketry_diagnose::{Gain, NamedCause, Report, measured, p_value, significant};
use bracketry_system::TimeUnit;

use super::Diagnosis;
use super::ranks::rank_change_text;
use super::sentences::{self, closeness, reason, regime};
use crate::html::{self, Figure, equations, escaped, heading, paragraph, percent, symbol, table, verbatim};

impl Diagnosis {
    /// The report as an HTML page with the given figures in it; it needs no network and no other file.
    pub fn page(&self, figures: &[Figure]) -> String {
        let report = &self.report;
        let title = format!("{}: {}", report.model, report.verdict);
        html::page(&title, &(heading(1, &report.model) + &self.section(figures, 2)))
    }

    /// The same as a part of a page, with headings from this level on.
    pub fn section(&self, figures: &[Figure], level: usize) -> String {
        let report = &self.report;
        let mut out = format!(
            "<p class=\"verdict\"><strong>{}</strong>: {}.</p>\n",
            report.verdict,
            escaped(&reason(&report.reason))
        );
        for cause in &report.causes {
            out += &of_cause(cause);
        }
        if let Some(gain) = &report.gain {
            out += &of_gain(gain, report.quantities.time_unit, level);
        }
        let pictures = html::figures(figures);
        if !pictures.is_empty() {
            out += &(heading(level, "Figures") + &pictures);
        }
        out += &tables(report, level);
        out += &self.model(level);
        out + &data(report, level)
    }

    /// The equations of the extended model, what they change in the analysis, and the model file.
    fn model(&self, level: usize) -> String {
        let Some(model) = &self.report.evidence.model else { return String::new() };
        let mut out = heading(level, "The extended model") + &equations(&model.system);
        for note in &model.notes {
            out += &paragraph(&format!("{note}."));
        }
        if let Ok(text) = model.to_toml() {
            out += &(paragraph("As a model file:") + &verbatim(&text));
        }
        if let Some(ranks) = &self.ranks {
            out += &verbatim(&rank_change_text(ranks));
        }
        out
    }
}

fn of_cause(cause: &NamedCause) -> String {
    let title = cause.name.words();
    let mut out = format!(
        "<div class=\"cause\"><h4>{} in the equation of {}</h4>\n<p>{}</p>\n<ul>",
        escaped(&title),
        symbol(&cause.equation),
        cause.term.notation().mathml()
    );
    for (name, value) in cause.parameters.iter() {
        let _ = write!(out, "<li>{} = {}</li>", symbol(name), escaped(&value.to_string()));
    }
    let _ = match cause.p_value {
        Some(p) => write!(out, "<li>p-value: {}</li>", escaped(&p_value(p))),
        None => write!(out, "<li>without the cause some of the data cannot be simulated</li>"),
    };
    if let Some(share) = cause.share {
        let _ = write!(out, "<li>without it {} of the excess would remain</li>", percent(share));
    }
    for line in cause.combination.iter().flat_map(sentences::combination) {
        let _ = write!(out, "<li>{}</li>", escaped(&line));
    }
    for flag in &cause.flags {
        let _ = write!(out, "<li>caution: {}</li>", escaped(&sentences::flag(flag)));
    }
    out += "</ul>\n";
    if !cause.rivals.is_empty() {
        out += "<p>This experiment cannot distinguish it from:</p><ul>";
        for rival in &cause.rivals {
            let name = rival.name.words();
            let _ = write!(
                out,
                "<li>{} in {}: {} ({})</li>",
                escaped(&name),
                symbol(&rival.equation),
                rival.term.notation().mathml(),
                escaped(&closeness(rival.closeness))
            );
        }
        out += "</ul>";
    }
    if !cause.separating_experiment.is_empty() {
        let _ = write!(out, "<p>To distinguish them: {}</p>", escaped(&cause.separating_experiment));
    }
    out + "</div>\n"
}

fn of_gain(gain: &Gain, time: TimeUnit, level: usize) -> String {
    let data = if gain.held_out { "held-out data" } else { "the data of the fit" };
    let rows = (0..gain.horizons_s.len()).map(|k| {
        vec![
            time.text(gain.horizons_s[k]),
            percent(gain.as_given[k]),
            percent(gain.before[k]),
            percent(gain.after[k]),
            gain.predictions[k].to_string(),
        ]
    });
    let mut out = heading(level, &format!("Gain on {data}")) + &paragraph(&gain.metric);
    if gain.horizons_s.is_empty() {
        out += &paragraph("No predictions: the horizons exceed the held-out data.");
    } else {
        out += &table(&["horizon", "as given", "refitted", "extended", "predictions"], rows);
    }
    if let (Some(before), Some(after)) = (gain.equation_error_before, gain.equation_error_after) {
        let (before, after) = (percent(before), percent(after));
        out += &paragraph(&format!("Force error relative to the applied force: {before} before, {after} after."));
    }
    out
}

fn tables(report: &Report, level: usize) -> String {
    let mut out = String::new();
    if !report.places.is_empty() {
        let rows = report.places.iter().chain(&report.regimes).map(|p| {
            let time = p.time.map_or_else(String::new, percent);
            vec![symbol(&p.equation), escaped(&regime(&p.regime)), percent(p.share), time]
        });
        out += &heading(level, "Where the refitted model is wrong");
        out += &table(&["equation", "when", "share of the excess", "share of the time"], rows);
    }
    if !report.parameters.is_empty() {
        let rows = report.parameters.iter().map(|p| {
            let interval = p
                .interval
                .map_or_else(String::new, |[a, b]| format!("{} … {}", measured(a, p.std), measured(b, p.std)));
            vec![
                symbol(&p.name),
                p.before.to_string(),
                measured(p.after, p.std),
                significant(p.std, 2),
                interval,
                escaped(&p.unit),
            ]
        });
        out += &heading(level, "Parameters, refitted");
        out += &table(&["parameter", "before", "after", "std", "95 %", "unit"], rows);
    }
    if !report.candidates.is_empty() {
        let rows = report.candidates.iter().map(|c| {
            let mark = if c.chosen { "selected" } else { "" };
            vec![
                mark.to_owned(),
                escaped(&c.name.words()),
                symbol(&c.equation),
                c.term.notation().mathml(),
                c.share.map_or_else(String::new, percent),
                c.interval.map_or_else(String::new, |[low, high]| format!("{} … {}", percent(low), percent(high))),
                escaped(&p_value(c.p_value)),
            ]
        });
        out += &heading(level, "Candidates, each alone");
        out += &table(&["", "candidate", "in", "term", "explains", "95 %", "p"], rows);
    }
    out
}

fn data(report: &Report, level: usize) -> String {
    let mut out = String::new();
    if !report.data.is_empty() {
        out += &heading(level, "Data");
        for audit in &report.data {
            out += &verbatim(&audit.to_string());
        }
    }
    if !report.notes.is_empty() {
        out += &(heading(level, "Notes") + "<ul>");
        for note in &report.notes {
            let _ = write!(out, "<li>{}</li>", escaped(&sentences::note(note)));
        }
        out += "</ul>\n";
    }
    out
}
