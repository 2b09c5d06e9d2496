//! Pages that need no network and no other file: one style, and the pieces that they are made of.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bracketry_plot::{Drawing, PlotError};
use bracketry_symbolic::Notation;
use bracketry_system::System;

use crate::notation::rate;

const STYLE: &str = "\
body{font:16px/1.5 system-ui,sans-serif;color:#262626;max-width:52rem;margin:2rem auto;padding:0 1rem}\
h1{font-size:1.6rem;margin-bottom:.2rem}h2{font-size:1.2rem;margin-top:2.2rem;border-bottom:1px solid #ccc}\
h3{font-size:1.05rem;margin-top:1.6rem}\
table{border-collapse:collapse;margin:.6rem 0}td,th{padding:.2rem .8rem .2rem 0;text-align:left;vertical-align:top}\
th{border-bottom:1px solid #262626;font-weight:600}td{border-bottom:1px solid #e4e4e4}\
.verdict{font-size:1.15rem}.cause{border-left:4px solid #0072b2;padding-left:1rem;margin:1.2rem 0}\
.cause h4{font-size:1rem;margin:.2rem 0}math{font-size:1.1em}mi[mathvariant]{padding:0 .12em}figure{margin:1.2rem 0;break-inside:avoid}\
figure svg,figure img{max-width:100%;height:auto}figcaption{color:#555;font-size:.9rem}.wide{overflow-x:auto}\
pre{background:#f5f5f5;padding:.8rem;overflow-x:auto;font-size:.75rem;white-space:pre-wrap}\
code{overflow-wrap:anywhere}\
@media screen and (max-width:45rem){figure{overflow-x:auto}figure svg,figure img{max-width:none;width:44rem}\
pre{white-space:pre}}\
@media print{body{margin:0;max-width:none}h2{break-after:avoid}pre,table{break-inside:avoid}}";

/// A figure with what is to be said about it.
pub struct Figure {
    /// Name of its files, without ending.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The figure, or why it cannot be drawn.
    pub drawing: Result<Drawing, PlotError>,
}

/// Text in which no sign has a meaning of its own in HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The name of a state, input, or parameter, set.
pub fn symbol(name: &str) -> String {
    Notation::symbol(name).mathml()
}

/// A page with this title and body.
pub fn page(title: &str, body: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\"><title>{0}</title><style>{STYLE}</style></head><body>\n\
         {body}</body></html>\n",
        escaped(title)
    )
}

/// A heading of a level from 1 to 6.
pub fn heading(level: usize, text: &str) -> String {
    format!("<h{level}>{}</h{level}>\n", escaped(text))
}

/// A paragraph of plain text.
pub fn paragraph(text: &str) -> String {
    format!("<p>{}</p>\n", escaped(text))
}

/// Text as it stands, in lines of its own.
pub fn verbatim(text: &str) -> String {
    format!("<pre>{}</pre>\n", escaped(text))
}

/// A row of cells, which are HTML already.
fn row<S: AsRef<str>>(tag: &str, cells: impl IntoIterator<Item = S>) -> String {
    let mut out = "<tr>".to_owned();
    for cell in cells {
        let _ = write!(out, "<{tag}>{}</{tag}>", cell.as_ref());
    }
    out + "</tr>"
}

/// A table; header and cells are HTML already. Without a header where that is empty.
pub fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut out = "<div class=\"wide\"><table>".to_owned();
    if !header.is_empty() {
        out += &row("th", header);
    }
    for cells in rows {
        out += &row("td", cells);
    }
    out + "</table></div>\n"
}

/// The equations of a model, set.
pub fn equations(system: &System) -> String {
    let names = system.state_names();
    let rows = names.iter().zip(&system.dynamics);
    table(&[], rows.map(|(name, &e)| vec![format!("{} ′ =", symbol(name)), rate(system, e).mathml()]))
}

/// Figures inside the page; those that cannot be drawn are left out.
pub fn figures(figures: &[Figure]) -> String {
    let mut out = String::new();
    for figure in figures {
        let Ok(drawing) = &figure.drawing else { continue };
        // Inside a page the image needs no declaration of its own.
        let svg = drawing.svg();
        let svg = svg.find("<svg").map_or(svg, |at| &svg[at..]);
        let _ = writeln!(out, "<figure>{svg}<figcaption>{}</figcaption></figure>", escaped(&figure.caption));
    }
    out
}

/// A GIF inside the page.
pub fn animation(gif: &[u8], caption: &str) -> String {
    let (data, caption) = (STANDARD.encode(gif), escaped(caption));
    format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/gif;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
    )
}

/// A share in percent.
pub fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
