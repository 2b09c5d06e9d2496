//! Lines, areas and texts in figure pixels, drawn through plotters' SVG back end.
//!
//! The back end has whole-number coordinates, knows no dashes and centers text by a rule that differs between
//! viewers. So it gets [`UNITS`] units per pixel (the SVG's view box scales them back), the last decimal digit
//! of a stroke width names the dash pattern, its digits from [`TAG`] on the curve, both put in when the document is finished, and
//! every text is placed by its base line.

use std::cell::RefCell;
use std::fmt::Write as _;

use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Rectangle, Text};
use plotters::prelude::SVGBackend;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontDesc, FontFamily, FontStyle, FontTransform, RGBAColor, ShapeStyle};

use crate::color::Color;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result};
use crate::glyphs::PlacedText;
pub(crate) use crate::glyphs::{Align, Look};
use crate::text::{FAMILY, SIZE};

/// Back-end units per figure pixel: stroke widths in quarters of a pixel are multiples of ten.
pub(crate) const UNITS: f64 = 40.0;
/// Greatest height in pixels, within the range of back-end units.
const TALLEST: u32 = 1_000_000;
/// Offset of the base line from the position the back end gets, in em.
const TOP_TO_BASE: f64 = 0.76;
/// The back end divides font sizes by this.
const FONT_DIVISOR: f64 = 1.24;

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// Unbroken.
    #[default]
    Solid,
    /// Long strokes.
    Dashed,
    /// Dots.
    Dotted,
    /// Strokes and dots in turn.
    DashDot,
}

impl Dash {
    pub(crate) const ALL: [Self; 4] = [Self::Solid, Self::Dashed, Self::Dotted, Self::DashDot];

    /// Lengths of strokes and gaps in pixels, to which round ends add the line's width.
    fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[6.0, 5.0],
            Self::Dotted => &[0.5, 4.0],
            Self::DashDot => &[6.5, 4.5, 0.5, 4.5],
        }
    }
}

/// Color, width in pixels and dashes of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stroke {
    pub(crate) color: Color,
    pub(crate) width: f64,
    pub(crate) dash: Dash,
}

impl Stroke {
    pub(crate) fn solid(color: Color, width: f64) -> Self {
        let dash = Dash::Solid;
        Self { color, width, dash }
    }
}

/// A rectangle in figure pixels, y downwards.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rect {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

impl Rect {
    pub(crate) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(crate) fn height(&self) -> f64 {
        self.bottom - self.top
    }
}

impl Look {
    pub(crate) const PLAIN: Self = Self { size: SIZE, bold: false, upright: false };
}

/// The sheet that figures are drawn on.
pub(crate) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
    /// What a raster image draws itself.
    texts: RefCell<Vec<PlacedText>>,
    /// Attributes of the curves.
    curves: RefCell<Vec<String>>,
    /// Elements that are not seen.
    unseen: RefCell<String>,
}

/// Draws on a white sheet of `width` × `height` pixels.
pub(crate) fn paint(width: f64, height: f64, draw: impl FnOnce(&Canvas) -> Result<()>) -> Result<Drawing> {
    let (width, height) = (width.ceil() as u32, height.ceil() as u32);
    if height > TALLEST {
        return Err(PlotError::TooLarge { width, height });
    }
    let units = UNITS as u32;
    let mut svg = String::new();
    let (texts, curves, unseen) = {
        let backend = SVGBackend::with_string(&mut svg, (width * units, height * units));
        let canvas = Canvas {
            area: backend.into_drawing_area(),
            texts: RefCell::default(),
            curves: RefCell::default(),
            unseen: RefCell::default(),
        };
        let page = Rect { left: 0.0, top: 0.0, right: f64::from(width), bottom: f64::from(height) };
        canvas.rect(page, Color(255, 255, 255))?;
        draw(&canvas)?;
        canvas.area.present()?;
        (canvas.texts.into_inner(), canvas.curves.into_inner(), canvas.unseen.into_inner())
    };
    Ok(Drawing::new(finish(&svg, (width, height), &curves, &unseen), texts, width, height))
}

/// Stroke widths with dash patterns stay below this; a multiple of it is the number of a curve, from 1 on.
const TAG: usize = 100_000;
/// How a stroke width stands in the document.
const KEY: &str = "stroke-width=\"";

/// Gives the document its size in pixels, the dash patterns, the names of the curves, and what is not seen.
fn finish(svg: &str, (width, height): (u32, u32), curves: &[String], unseen: &str) -> String {
    let units = UNITS as u32;
    let mut out = format!(
        "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {} {}\" xmlns=\"http://www.w3.org/2000/svg\" stroke-linejoin=\"round\" stroke-linecap=\"round\">\n",
        width * units,
        height * units
    );
    for line in svg.lines().skip(1) {
        let dashed = line.starts_with("<polyline").then(|| line.split_once(KEY)).flatten();
        let Some((before, (number, after))) = dashed.and_then(|(b, rest)| Some((b, rest.split_once('"')?))) else {
            if line == "</svg>" {
                out.push_str(unseen);
            }
            out.push_str(line);
            out.push('\n');
            continue;
        };
        let number: usize = number.parse().unwrap_or(0);
        let (curve, code) = (number / TAG, number % TAG);
        out.push_str(before);
        let _ = write!(out, "{KEY}{}\"", code - code % 10);
        let pattern = Dash::ALL.get(code % 10).map_or(&[][..], |d| d.pattern());
        if !pattern.is_empty() {
            let lengths: Vec<String> = pattern.iter().map(|l| (l * UNITS).to_string()).collect();
            let _ = write!(out, " stroke-dasharray=\"{}\"", lengths.join(" "));
        }
        if let Some(attributes) = curve.checked_sub(1).and_then(|k| curves.get(k)) {
            out.push_str(attributes);
        }
        out.push_str(after);
        out.push('\n');
    }
    out
}

/// A text in which characters that XML does not allow (control characters, noncharacters) are spaces.
pub(crate) fn visible(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || ('\u{fffe}'..='\u{ffff}').contains(&c) { ' ' } else { c }).collect()
}

fn units(point: (f64, f64)) -> (i32, i32) {
    ((point.0 * UNITS).round() as i32, (point.1 * UNITS).round() as i32)
}

fn style(color: Color, stroke_width: u32, filled: bool) -> ShapeStyle {
    ShapeStyle { color: RGBAColor(color.0, color.1, color.2, 1.0), filled, stroke_width }
}

impl Canvas<'_> {
    /// An open line through `points`.
    pub(crate) fn line(&self, points: &[(f64, f64)], stroke: Stroke) -> Result<()> {
        self.tagged(points, stroke, 0)
    }

    /// The same for a curve whose values can be read, with attributes that say which one it is.
    pub(crate) fn curve(&self, points: &[(f64, f64)], stroke: Stroke, attributes: String) -> Result<()> {
        let mut curves = self.curves.borrow_mut();
        curves.push(attributes);
        self.tagged(points, stroke, curves.len())
    }

    /// A line with a number; 0 for none.
    fn tagged(&self, points: &[(f64, f64)], stroke: Stroke, tag: usize) -> Result<()> {
        if points.len() < 2 {
            return Ok(());
        }
        let quarters = (stroke.width * 4.0).round().max(1.0) as u32;
        let code = Dash::ALL.iter().position(|d| *d == stroke.dash).unwrap_or(0) as u32;
        let path: Vec<_> = points.iter().map(|p| units(*p)).collect();
        // Beyond some ten thousand curves, which nobody reads, the number has no room.
        let tag = u32::try_from(tag * TAG).unwrap_or(0);
        let look = style(stroke.color, tag + quarters * 10 + code, false);
        Ok(self.area.draw(&PathElement::new(path, look))?)
    }

    /// Adds an element that is not seen.
    pub(crate) fn unseen(&self, element: &str) {
        let mut unseen = self.unseen.borrow_mut();
        unseen.push_str(element);
        unseen.push('\n');
    }

    /// A filled polygon.
    pub(crate) fn polygon(&self, points: &[(f64, f64)], color: Color) -> Result<()> {
        let path: Vec<_> = points.iter().map(|p| units(*p)).collect();
        Ok(self.area.draw(&Polygon::new(path, style(color, 0, true)))?)
    }

    /// A filled rectangle.
    pub(crate) fn rect(&self, rect: Rect, color: Color) -> Result<()> {
        let corners = [units((rect.left, rect.top)), units((rect.right, rect.bottom))];
        Ok(self.area.draw(&Rectangle::new(corners, style(color, 0, true)))?)
    }

    /// The border of a rectangle.
    pub(crate) fn border(&self, r: Rect, stroke: Stroke) -> Result<()> {
        let corners = [(r.left, r.top), (r.right, r.top), (r.right, r.bottom), (r.left, r.bottom), (r.left, r.top)];
        self.line(&corners, stroke)
    }

    /// A filled disk.
    pub(crate) fn disk(&self, center: (f64, f64), radius: f64, color: Color) -> Result<()> {
        let radius = (radius * UNITS).round() as i32;
        Ok(self.area.draw(&Circle::new(units(center), radius, style(color, 0, true)))?)
    }

    /// A gray rectangle with slanting lines: nothing is known there.
    pub(crate) fn hatch(&self, r: Rect) -> Result<()> {
        self.rect(r, Color(232, 232, 232))?;
        self.slanting(r, 7.0, Stroke::solid(Color(150, 150, 150), 0.75))
    }

    /// The lines x + y = k · `spacing` inside a rectangle; they run on from one rectangle to the next.
    fn slanting(&self, r: Rect, spacing: f64, stroke: Stroke) -> Result<()> {
        let first = ((r.left + r.top) / spacing).ceil() as i64;
        let last = ((r.right + r.bottom) / spacing).floor() as i64;
        (first..=last).try_for_each(|k| {
            let sum = k as f64 * spacing;
            let (from, to) = ((sum - r.bottom).max(r.left), (sum - r.top).min(r.right));
            self.line(&[(from, sum - from), (to, sum - to)], stroke)
        })
    }

    /// A bar of series number `index`: full, with white slanting lines, with white level lines, and so on, so that neighbors are told
    /// apart without their colors.
    pub(crate) fn bar(&self, r: Rect, color: Color, index: usize) -> Result<()> {
        const SPACING: f64 = 6.0;
        self.rect(r, color)?;
        let white = Stroke::solid(Color(255, 255, 255), 1.0);
        match index % 3 {
            1 => self.slanting(r, SPACING, white)?,
            2 => {
                let count = ((r.height() - 1.0) / SPACING).floor().max(0.0) as usize;
                for k in 1..=count {
                    let y = r.bottom - SPACING * k as f64;
                    self.line(&[(r.left, y), (r.right, y)], white)?;
                }
            }
            _ => {}
        }
        self.border(r, Stroke::solid(color, 1.0))
    }

    /// A triangle with its tip at `(x, y)`, upwards or downwards: something goes on beyond a frame there.
    pub(crate) fn beyond(&self, (x, y): (f64, f64), upwards: bool, color: Color) -> Result<()> {
        let down = if upwards { 9.0 } else { -9.0 };
        self.polygon(&[(x, y), (x - 6.0, y + down), (x + 6.0, y + down)], color)
    }

    /// A small gray cross: nothing is known there.
    pub(crate) fn cross(&self, (x, y): (f64, f64)) -> Result<()> {
        let stroke = Stroke::solid(Color::GRAY, 1.0);
        self.line(&[(x - 3.0, y - 3.0), (x + 3.0, y + 3.0)], stroke)?;
        self.line(&[(x - 3.0, y + 3.0), (x + 3.0, y - 3.0)], stroke)
    }

    /// An arrow from `tail` along `(dx, dy)`; a short one has a smaller head, a vanishing one is a dot.
    pub(crate) fn arrow(&self, tail: (f64, f64), (dx, dy): (f64, f64), color: Color) -> Result<()> {
        let length = dx.hypot(dy);
        if length < 1.5 {
            return self.disk(tail, 1.5, color);
        }
        let (along, across) = ((dx / length, dy / length), (-dy / length, dx / length));
        let head = (0.45 * length).min(8.0);
        let tip = (tail.0 + dx, tail.1 + dy);
        let base = (tip.0 - head * along.0, tip.1 - head * along.1);
        let corner = |side: f64| (base.0 + side * 0.42 * head * across.0, base.1 + side * 0.42 * head * across.1);
        self.line(&[tail, base], Stroke::solid(color, 1.5))?;
        self.polygon(&[corner(1.0), tip, corner(-1.0)], color)
    }

    /// One line of text whose base line runs through `at`.
    pub(crate) fn text(&self, text: &str, at: (f64, f64), align: Align, look: Look) -> Result<()> {
        let clean = visible(text);
        self.texts.borrow_mut().push(PlacedText { text: clean.clone(), at, align, look });
        let up = TOP_TO_BASE * look.size;
        let (at, turn) = if look.upright {
            ((at.0 - up, at.1), FontTransform::Rotate270)
        } else {
            ((at.0, at.1 - up), FontTransform::None)
        };
        let anchor = match align {
            Align::Left => HPos::Left,
            Align::Center => HPos::Center,
            Align::Right => HPos::Right,
        };
        let weight = if look.bold { FontStyle::Bold } else { FontStyle::Normal };
        let ink = Color::INK;
        let font = FontDesc::new(FontFamily::Name(FAMILY), look.size * UNITS * FONT_DIVISOR, weight)
            .transform(turn)
            .color(&RGBAColor(ink.0, ink.1, ink.2, 1.0))
            .pos(Pos::new(anchor, VPos::Top));
        Ok(self.area.draw(&Text::new(clean, units(at), font))?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dashes_reach_the_document_and_widths_are_true() -> Result<()> {
        let drawing = paint(100.0, 50.0, |canvas| {
            for dash in Dash::ALL {
                let stroke = Stroke { color: Color::INK, width: 1.5, dash };
                canvas.line(&[(0.0, 0.0), (10.5, 20.25)], stroke)?;
            }
            Ok(())
        })?;
        let svg = drawing.svg();
        assert_eq!(svg.matches("stroke-width=\"60\"").count(), 4);
        assert_eq!(svg.matches("stroke-dasharray=\"240 200\"").count(), 1);
        assert_eq!(svg.matches("stroke-dasharray").count(), 3);
        assert_eq!(svg.matches("420,810").count(), 4);
        assert!(svg.starts_with("<svg width=\"100\" height=\"50\" viewBox=\"0 0 4000 2000\""));
        Ok(())
    }

    #[test]
    fn markup_and_control_characters_in_texts_are_harmless() -> Result<()> {
        let drawing = paint(100.0, 50.0, |canvas| {
            let name = "a<b>&\u{1} stroke-width=\"61\"";
            canvas.text(name, (10.0, 20.0), Align::Left, Look::PLAIN)
        })?;
        assert!(drawing.svg().contains("a&lt;b&gt;&amp;  stroke-width=&quot;61&quot;"));
        assert!(drawing.png().is_ok());
        Ok(())
    }
}
