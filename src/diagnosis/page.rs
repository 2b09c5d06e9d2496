//! The report as one page that needs nothing else: text, tables, formulas and figures.

use std::fmt::Write as _;

use bracketry_diagnose::{Gain, NamedCause, Report};

use super::mathml::{escaped, formula, math};
use super::{Diagnosis, Figure};

const STYLE: &str = "\
body{font:16px/1.5 system-ui,sans-serif;color:#262626;max-width:52rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.6rem;margin-bottom:.2rem}h2{font-size:1.2rem;margin-top:2.2rem;border-bottom:1px solid #ccc}\
table{border-collapse:collapse;margin:.6rem 0}td,th{padding:.2rem .8rem .2rem 0;text-align:left;vertical-align:top}\
th{border-bottom:1px solid #262626;font-weight:600}td{border-bottom:1px solid #e4e4e4}\
.verdict{font-size:1.15rem}.cause{border-left:4px solid #0072b2;padding-left:1rem;margin:1.2rem 0}\
.cause h3{margin:.2rem 0}math{font-size:1.1em}figure{margin:1.2rem 0;break-inside:avoid}\
figure svg{max-width:100%;height:auto}figcaption{color:#555;font-size:.9rem}\
pre{background:#f5f5f5;padding:.8rem;overflow-x:auto;font-size:.85rem;white-space:pre-wrap}\
@media print{body{margin:0;max-width:none}h2{break-after:avoid}pre,table{break-inside:avoid}}";

impl Diagnosis {
    /// The report as an HTML page with the given figures in it; it needs no network and no other file.
    pub fn page(&self, figures: &[Figure]) -> String {
        let report = &self.report;
        let mut page = format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width\"><title>{0}: {1}</title><style>{STYLE}</style></head><body>\n\
             <h1>{0}</h1>\n<p class=\"verdict\"><strong>{1}</strong>: {2}.</p>\n",
            escaped(&report.model),
            report.verdict,
            escaped(&report.reason)
        );
        for cause in &report.causes {
            page += &of_cause(cause);
        }
        if let Some(gain) = &report.gain {
            page += &of_gain(gain);
        }
        page += &pictures(figures);
        page += &tables(report);
        page += &self.model();
        page += &data(report);
        page + "</body></html>\n"
    }

    /// The equations of the extended model, what they change in the analysis, and the model file.
    fn model(&self) -> String {
        let Some(model) = &self.report.evidence.model else { return String::new() };
        let mut out = "<h2>The extended model</h2>\n<table>".to_owned();
        let system = &model.system;
        for (name, rate) in system.state_names().iter().zip(&system.dynamics) {
            let set = math(&system.pool.latex(*rate));
            let _ = write!(out, "<tr><td>{} ′ =</td><td>{set}</td></tr>", formula(name));
        }
        out += "</table>\n";
        for note in &model.notes {
            let _ = write!(out, "<p>{}.</p>", escaped(note));
        }
        if let Ok(text) = model.to_toml() {
            let _ = writeln!(out, "<p>As a model file:</p><pre>{}</pre>", escaped(&text));
        }
        if let Some(ranks) = &self.ranks {
            let _ = writeln!(out, "<pre>{}</pre>", escaped(&ranks.to_string()));
        }
        out
    }
}

fn row<S: AsRef<str>>(tag: &str, cells: impl IntoIterator<Item = S>) -> String {
    let mut out = "<tr>".to_owned();
    for cell in cells {
        let _ = write!(out, "<{tag}>{}</{tag}>", cell.as_ref());
    }
    out + "</tr>"
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn of_cause(cause: &NamedCause) -> String {
    let title = cause.name.to_string().replace('_', " ");
    let mut out = format!(
        "<div class=\"cause\"><h3>{} in the equation of {}</h3>\n<p>{}</p>\n<ul>",
        escaped(&title),
        formula(&cause.equation),
        formula(&cause.term)
    );
    for (name, value) in &cause.parameters {
        let _ = write!(out, "<li>{} = {}</li>", formula(name), escaped(&value.to_string()));
    }
    let _ = match cause.p_value {
        Some(p) => write!(out, "<li>probability without the cause: {p:.1e}</li>"),
        None => write!(out, "<li>without the cause some of the data cannot be simulated</li>"),
    };
    if let Some(share) = cause.share {
        let _ = write!(out, "<li>without it {} of the excess error would remain</li>", percent(share));
    }
    for flag in &cause.flags {
        let _ = write!(out, "<li>caution: {}</li>", escaped(flag));
    }
    out += "</ul>\n";
    if !cause.rivals.is_empty() {
        out += "<p>This experiment cannot tell it from:</p><ul>";
        for rival in &cause.rivals {
            let name = rival.name.to_string().replace('_', " ");
            let _ = write!(
                out,
                "<li>{} in {}: {} ({})</li>",
                escaped(&name),
                formula(&rival.equation),
                formula(&rival.term),
                escaped(&rival.why)
            );
        }
        out += "</ul>";
    }
    if !cause.separating_experiment.is_empty() {
        let _ = write!(out, "<p>To tell them apart: {}</p>", escaped(&cause.separating_experiment));
    }
    out + "</div>\n"
}

fn of_gain(gain: &Gain) -> String {
    let data = if gain.held_out { "held-out data" } else { "the data of the fit" };
    let mut out = format!("<h2>Gain on {data}</h2>\n<p>{}</p>\n<table>", escaped(&gain.metric));
    out += &row("th", ["horizon", "as given", "refitted", "extended", "predictions"]);
    for k in 0..gain.horizons_s.len() {
        let cells = [
            format!("{} s", gain.horizons_s[k]),
            percent(gain.as_given[k]),
            percent(gain.before[k]),
            percent(gain.after[k]),
            gain.predictions[k].to_string(),
        ];
        out += &row("td", cells);
    }
    out += "</table>\n";
    if let (Some(before), Some(after)) = (gain.equation_error_before, gain.equation_error_after) {
        let _ = writeln!(
            out,
            "<p>Force error relative to the applied force: {} before, {} after.</p>",
            percent(before),
            percent(after)
        );
    }
    out
}

fn pictures(figures: &[Figure]) -> String {
    let drawn: Vec<_> = figures.iter().filter_map(|f| Some((f, f.drawing.as_ref().ok()?))).collect();
    let mut out = String::new();
    if !drawn.is_empty() {
        out += "<h2>Figures</h2>\n";
    }
    for (figure, drawing) in drawn {
        // Inside a page the image needs no declaration of its own.
        let svg = drawing.svg();
        let svg = svg.find("<svg").map_or(svg, |at| &svg[at..]);
        let _ = writeln!(out, "<figure>{svg}<figcaption>{}</figcaption></figure>", escaped(&figure.caption));
    }
    out
}

fn tables(report: &Report) -> String {
    let mut out = String::new();
    if !report.places.is_empty() {
        out += "<h2>Where the refitted model is wrong</h2>\n<table>";
        out += &row("th", ["equation", "when", "share of the excess error", "share of the time"]);
        for p in report.places.iter().chain(&report.regimes) {
            let time = p.time.map_or_else(String::new, percent);
            out += &row("td", [formula(&p.equation), escaped(&p.regime), percent(p.share), time]);
        }
        out += "</table>\n";
    }
    if !report.parameters.is_empty() {
        out += "<h2>Parameters, refitted</h2>\n<table>";
        out += &row("th", ["parameter", "before", "after", "std", "95 %", "unit"]);
        for p in &report.parameters {
            let interval = p.interval.map_or_else(String::new, |[a, b]| format!("{a:.5} … {b:.5}"));
            let cells = [
                formula(&p.name),
                p.before.to_string(),
                format!("{:.5}", p.after),
                format!("{:.1e}", p.std),
                interval,
                escaped(&p.unit),
            ];
            out += &row("td", cells);
        }
        out += "</table>\n";
    }
    if !report.candidates.is_empty() {
        out += "<h2>What was tried, each alone</h2>\n<table>";
        out += &row("th", ["", "candidate", "in", "term", "explains", "95 %", "p"]);
        for c in &report.candidates {
            let mark = if c.chosen { "named" } else { "" };
            let name = escaped(&c.name.to_string().replace('_', " "));
            let cells = [
                mark.to_owned(),
                name,
                formula(&c.equation),
                formula(&c.term),
                c.share.map_or_else(String::new, percent),
                c.interval.map_or_else(String::new, |[low, high]| format!("{} … {}", percent(low), percent(high))),
                format!("{:.1e}", c.p_value),
            ];
            out += &row("td", cells);
        }
        out += "</table>\n";
    }
    out
}

fn data(report: &Report) -> String {
    let mut out = String::new();
    if !report.data.is_empty() {
        out += "<h2>Data</h2>\n";
        for audit in &report.data {
            let _ = writeln!(out, "<pre>{}</pre>", escaped(&audit.to_string()));
        }
    }
    if !report.notes.is_empty() {
        out += "<h2>Notes</h2>\n<ul>";
        for note in &report.notes {
            let _ = write!(out, "<li>{}</li>", escaped(note));
        }
        out += "</ul>\n";
    }
    out
}
