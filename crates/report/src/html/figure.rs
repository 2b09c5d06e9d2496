//! Figures and animations inside a page.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use bracketry_plot::{Drawing, PlotError};

use super::{escaped, folded};

/// A figure with what is to be said about it.
pub struct Figure {
    /// Name of its files, without ending.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The figure, or why it cannot be drawn.
    pub drawing: Result<Drawing, PlotError>,
}

impl Figure {
    /// A figure with the name of its files and its caption.
    pub fn new(name: impl Into<String>, caption: impl Into<String>, drawing: Result<Drawing, PlotError>) -> Self {
        Self { name: name.into(), caption: caption.into(), drawing }
    }
}

/// Figures inside the page, whose values are read by pointer and arrow keys; those that cannot be drawn are left out.
pub fn figures<'a>(figures: impl IntoIterator<Item = &'a Figure>) -> String {
    let mut out = String::new();
    for figure in figures {
        let Ok(drawing) = &figure.drawing else { continue };
        // Inside a page the image needs no declaration of its own, but a name.
        let (svg, caption) = (drawing.svg(), escaped(&figure.caption));
        let svg = svg.find("<svg").map_or(svg, |at| &svg[at + "<svg".len()..]);
        let _ = writeln!(
            out,
            "<figure><div class=\"plot\" tabindex=\"0\" role=\"group\" aria-label=\"Values by arrow keys: {caption}\">\
             <svg role=\"img\" preserveAspectRatio=\"xMinYMin\" aria-label=\"{caption}\"{svg}</div><figcaption>{caption}</figcaption></figure>"
        );
    }
    out
}

/// The first figure, and the others folded under their captions.
pub fn gallery<'a>(all: impl IntoIterator<Item = &'a Figure>) -> String {
    let mut drawn = all.into_iter().filter(|f| f.drawing.is_ok());
    figures(drawn.next()) + &folded_figures(drawn)
}

/// All figures folded under their captions, below something else to look at.
pub fn folded_figures<'a>(all: impl IntoIterator<Item = &'a Figure>) -> String {
    let drawn = all.into_iter().filter(|f| f.drawing.is_ok());
    drawn.map(|f| folded(&f.caption, &figures([f]))).collect()
}

/// A GIF inside the page, with a PNG of one image that takes its place where it is paused or less motion is preferred.
pub fn animation(gif: &[u8], still: &[u8], caption: &str) -> String {
    let (gif, still, caption) = (STANDARD.encode(gif), STANDARD.encode(still), escaped(caption));
    format!(
        "<figure><picture><source media=\"(prefers-reduced-motion: reduce)\" srcset=\"data:image/png;base64,{still}\"/>\
         <img alt=\"{caption}\" src=\"data:image/gif;base64,{gif}\"/></picture>\
         <button type=\"button\" aria-pressed=\"false\" aria-label=\"Pause: {caption}\" hidden>Pause</button>\
         <figcaption>{caption}</figcaption></figure>\n"
    )
}
