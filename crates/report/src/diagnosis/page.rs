//! The report as one page that needs nothing else: text, tables, formulas and figures.

use std::fmt::Write as _;

use bracketry_diagnose::{Gain, NamedCause, Report, measured, p_value, significant};
use bracketry_system::TimeUnit;

use super::Diagnosis;
use super::ranks::rank_change_text;
use super::sentences::{self, closeness, reason, regime};
use crate::html::{
    self, Chapter, Figure, Page, equations, escaped, folded, list, paragraph, percent, symbol, table, verbatim, wide,
};

impl Diagnosis {
    /// The report as an HTML page with the given figures in it, and links to these files beside it; it needs no network and no other file.
    pub fn page(&self, figures: &[Figure], files: &[(String, String)]) -> String {
        let report = &self.report;
        let (first, others) = figures.split_at(figures.len().min(1));
        let lead = self.verdict() + &html::figures(first);
        let page = Page::new(format!("{}: {}", report.model, report.verdict), lead);
        let files = (!files.is_empty()).then(|| Chapter::files(files));
        page.chapters(self.chapters(others)).chapters(files).html()
    }

    /// The verdict with its reason.
    pub fn verdict(&self) -> String {
        let report = &self.report;
        format!("<p class=\"verdict\"><strong>{}</strong>: {}.</p>\n", report.verdict, escaped(&reason(&report.reason)))
    }

    /// What stands below the verdict, with the given figures in it.
    pub fn chapters(&self, figures: &[Figure]) -> Vec<Chapter> {
        let report = &self.report;
        let mut out = Vec::new();
        if !report.causes.is_empty() {
            out.push(Chapter::new("Causes", "").parts(report.causes.iter().map(of_cause)));
        }
        out.extend(report.gain.as_ref().map(|gain| of_gain(gain, report.quantities.time_unit)));
        let pictures = html::gallery(figures);
        if !pictures.is_empty() {
            out.push(Chapter::new("Figures", pictures));
        }
        out.extend(tables(report));
        out.extend(self.model());
        out.extend(data(report));
        if !self.next_experiments.is_empty() {
            let commands = self.next_experiments.iter().map(|next| {
                let purpose = format!("To distinguish {} from {}:", next.cause, next.rival);
                paragraph(&purpose) + &format!("<p><code>{}</code></p>\n", escaped(&next.command))
            });
            out.push(Chapter::new("Next experiments", commands.collect::<String>()));
        }
        out
    }

    /// The equations of the extended model, what they change in the analysis, and the model file.
    fn model(&self) -> Option<Chapter> {
        let model = self.report.evidence.model.as_ref()?;
        let mut out = equations(&model.system);
        for note in &model.notes {
            out += &paragraph(&format!("{note}."));
        }
        if let Ok(text) = model.to_toml() {
            out += &verbatim("The model file", &text);
        }
        if let Some(ranks) = &self.ranks {
            out += &verbatim("What it changes in what the inputs reach", &rank_change_text(ranks));
        }
        Some(Chapter::new("The extended model", out))
    }
}

fn of_cause(cause: &NamedCause) -> Chapter {
    let title = format!("{} in the equation of {}", cause.name.words(), cause.equation);
    let term = format!("<div class=\"cause\">{}</div>\n", wide(&title, &cause.term.notation().mathml()));
    let mut found = String::new();
    for (name, value) in cause.parameters.iter() {
        let _ = writeln!(found, "<p>{} = {}</p>", symbol(name), escaped(&value.to_string()));
    }
    let mut out = "<ul>".to_owned();
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
                "<li>{} in {} ({}): {}</li>",
                escaped(&name),
                symbol(&rival.equation),
                escaped(&closeness(rival.closeness)),
                wide(&format!("Term of {name} in {}", rival.equation), &rival.term.notation().mathml())
            );
        }
        out += "</ul>";
    }
    if !cause.separating_experiment.is_empty() {
        let _ = write!(out, "<p>To distinguish them: {}</p>", escaped(&cause.separating_experiment));
    }
    Chapter::new(title, term + &found + &folded("Evidence", &out))
}

fn of_gain(gain: &Gain, time: TimeUnit) -> Chapter {
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
    let mut out = paragraph(&gain.metric);
    if gain.horizons_s.is_empty() {
        out += &paragraph("No predictions: the horizons exceed the held-out data.");
    } else {
        out += &table("Errors of prediction", &["horizon", "as given", "refitted", "extended", "predictions"], rows);
    }
    if let (Some(before), Some(after)) = (gain.equation_error_before, gain.equation_error_after) {
        let (before, after) = (percent(before), percent(after));
        out += &paragraph(&format!("Force error relative to the applied force: {before} before, {after} after."));
    }
    Chapter::new(format!("Gain on {data}"), out)
}

fn tables(report: &Report) -> Vec<Chapter> {
    let mut out = Vec::new();
    let mut add = |title: &str, header: &[&str], rows: Vec<Vec<String>>| {
        out.push(Chapter::new(title, table(title, header, rows)));
    };
    if !report.places.is_empty() {
        let rows = report.places.iter().chain(&report.regimes).map(|p| {
            let time = p.time.map_or_else(String::new, percent);
            vec![symbol(&p.equation), escaped(&regime(&p.regime)), percent(p.share), time]
        });
        let header = ["equation", "when", "share of the excess", "share of the time"];
        add("Where the refitted model is wrong", &header, rows.collect());
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
        let header = ["parameter", "before", "after", "std", "95 %", "unit"];
        add("Parameters, refitted", &header, rows.collect());
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
        let header = ["", "candidate", "in", "term", "explains", "95 %", "p"];
        add("Candidates, each alone", &header, rows.collect());
    }
    out
}

fn data(report: &Report) -> Vec<Chapter> {
    let mut out = Vec::new();
    if !report.data.is_empty() {
        let audits = report
            .data
            .iter()
            .map(|audit| verbatim(&format!("Columns and noise of {}", audit.name), &audit.to_string()));
        out.push(Chapter::new("Data", audits.collect::<String>()));
    }
    if !report.notes.is_empty() {
        out.push(Chapter::new("Notes", list(report.notes.iter().map(sentences::note))));
    }
    out
}
