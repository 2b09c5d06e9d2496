//! What a page reads from a figure: the scales of its panels, the names of its curves, and the values of its marks, as attributes and
//! elements of the SVG that are not seen.
//!
//! A panel is `<g data-panel data-box data-x data-y data-title data-x-title/>`: its number, its frame in units of the view box (left, top, right, bottom), and
//! the values at the ends of its axes. A curve is a polyline with `data-panel`, `data-curve` (its number in the panel), `data-name`, and
//! `data-shift` (units of the view box by which it is set aside); a cloud is a `<g>` with the same and `data-points`. A mark with a value of its own, such as a bar, is an empty `<rect>` over it
//! with the value as its `<title>`.

use crate::axes::Axes;
use crate::canvas::{Canvas, Rect, UNITS, visible};
use crate::ticks::three_digits;

/// A curve of a panel.
pub(crate) struct Curve<'a> {
    /// Number of the panel in the figure.
    pub(crate) panel: usize,
    /// Number of the curve in the panel.
    pub(crate) index: usize,
    /// Name in the legend; may be empty.
    pub(crate) name: &'a str,
    /// Pixels by which the curve is set aside.
    pub(crate) shift: f64,
}

impl Curve<'_> {
    pub(crate) fn attributes(&self) -> String {
        let (panel, index, name) = (self.panel, self.index, attribute(self.name));
        let shift = if self.shift == 0.0 { String::new() } else { format!(" data-shift=\"{}\"", self.shift * UNITS) };
        format!(" data-panel=\"{panel}\" data-curve=\"{index}\" data-name=\"{name}\"{shift}")
    }
}

/// Notes the scales of a panel whose axes have these titles.
pub(crate) fn panel(canvas: &Canvas, number: usize, axes: &Axes, (x_title, y_title): (&str, &str)) {
    let r = axes.rect;
    let frame = [r.left, r.top, r.right, r.bottom].map(|v| (v * UNITS).round().to_string()).join(" ");
    canvas.unseen(&format!(
        "<g data-panel=\"{number}\" data-box=\"{frame}\" data-x=\"{} {}\" data-y=\"{} {}\" data-title=\"{}\" data-x-title=\"{}\"/>",
        axes.x.low,
        axes.x.high,
        axes.y.low,
        axes.y.high,
        attribute(y_title),
        attribute(x_title)
    ));
}

/// Points of a cloud beyond which it has no values to read.
const MOST_POINTS: usize = 3000;

/// Notes the points of a cloud.
pub(crate) fn points(canvas: &Canvas, curve: &Curve, points: &[(f64, f64)]) {
    if points.len() > MOST_POINTS {
        return;
    }
    let units = |(x, y): &(f64, f64)| format!("{},{}", (x * UNITS).round(), (y * UNITS).round());
    let list: Vec<String> = points.iter().map(units).collect();
    canvas.unseen(&format!("<g{} data-points=\"{}\"/>", curve.attributes(), list.join(" ")));
}

/// Notes the value of what is drawn in a rectangle.
pub(crate) fn value(canvas: &Canvas, r: Rect, text: &str) {
    let units = |v: f64| (v * UNITS).round();
    canvas.unseen(&format!(
        "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" pointer-events=\"all\"><title>{}</title></rect>",
        units(r.left),
        units(r.top),
        units(r.width()),
        units(r.height()),
        attribute(text)
    ));
}

/// A value with the unit that an axis label ends with in brackets.
pub(crate) fn with_unit(label: &str, value: f64) -> String {
    format!("{}{}", three_digits(value), unit_of(label))
}

/// The unit that a label ends with in brackets, as it is written behind a number.
pub(crate) fn unit_of(label: &str) -> String {
    let unit = label.strip_suffix(']').and_then(|l| l.rsplit_once('[')).map_or("", |(_, unit)| unit);
    if unit.is_empty() || unit == "°" { unit.to_owned() } else { format!(" {unit}") }
}

/// A text as the value of an attribute, or as text between tags.
fn attribute(text: &str) -> String {
    visible(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
