//! Legends: rows of samples with their names, kept outside the data.

use crate::canvas::{Align, Canvas, Look, Rect, Stroke};
use crate::color::Color;
use crate::error::Result;
use crate::text::{self, LEADING, SIZE};

/// Height of a row of a legend.
pub(crate) const ROW: f64 = SIZE * LEADING + 2.0;
const SAMPLE: f64 = 28.0;
const GAP: f64 = 7.0;
const BETWEEN: f64 = 22.0;
/// Lines that a very long name may take.
const MAX_LINES: usize = 4;

/// The shape of a data point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Marker {
    Disk,
    Square,
    Triangle,
    Diamond,
    /// Where something ends before its time.
    Cross,
}

impl Marker {
    pub(crate) fn series(index: usize) -> Self {
        [Self::Disk, Self::Square, Self::Triangle, Self::Diamond][index % 4]
    }

    pub(crate) fn draw(self, canvas: &Canvas, at: (f64, f64), color: Color) -> Result<()> {
        self.draw_sized(canvas, at, 4.0, color)
    }

    /// In the color of the text with a white rim, to be seen on any ground.
    pub(crate) fn draw_rimmed(self, canvas: &Canvas, at: (f64, f64)) -> Result<()> {
        self.draw_sized(canvas, at, 7.0, Color(255, 255, 255))?;
        self.draw_sized(canvas, at, 5.0, Color::INK)
    }

    pub(crate) fn draw_sized(self, canvas: &Canvas, (x, y): (f64, f64), r: f64, color: Color) -> Result<()> {
        match self {
            Self::Disk => canvas.disk((x, y), r, color),
            Self::Square => {
                let s = 0.88 * r;
                let square = Rect { left: x - s, top: y - s, right: x + s, bottom: y + s };
                canvas.rect(square, color)
            }
            Self::Triangle => {
                let (w, h) = (1.15 * r, 0.67 * r);
                canvas.polygon(&[(x - w, y + h), (x + w, y + h), (x, y - 2.0 * h)], color)
            }
            Self::Diamond => {
                let s = 1.25 * r;
                canvas.polygon(&[(x - s, y), (x, y + s), (x + s, y), (x, y - s)], color)
            }
            Self::Cross => {
                let (s, stroke) = (r, Stroke::solid(color, 0.5 * r));
                canvas.line(&[(x - s, y - s), (x + s, y + s)], stroke)?;
                canvas.line(&[(x - s, y + s), (x + s, y - s)], stroke)
            }
        }
    }
}

/// What stands before a name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Sample {
    /// A line, perhaps with a marker on it.
    Line(Stroke, Option<Marker>),
    /// A marker alone.
    Point(Marker, Color),
    /// A filled patch.
    Patch(Color),
    /// The pattern of bar number so and so.
    Bar(Color, usize),
    /// A triangle that points out of a frame.
    Beyond,
    /// A line going from pale to dark, of this width.
    Ramp(Color, f64),
    /// A dot.
    Dot(Color),
    /// A short line ending in a dot.
    Heading(Color),
    /// A hatched patch: nothing is known.
    Hatched,
    /// A small gray cross: nothing is known.
    Cross,
    /// A marker with a white rim.
    Mark(Marker),
    /// An arrow of this length in pixels.
    Arrow(f64),
}

impl Sample {
    /// Room that it takes before its name.
    fn width(self) -> f64 {
        match self {
            Self::Arrow(length) => length.max(SAMPLE),
            _ => SAMPLE,
        }
    }

    fn draw(self, canvas: &Canvas, left: f64, middle: f64) -> Result<()> {
        let right = left + SAMPLE;
        match self {
            Self::Line(stroke, marker) => {
                canvas.line(&[(left, middle), (right, middle)], stroke)?;
                match marker {
                    Some(m) => m.draw(canvas, (left + SAMPLE / 2.0, middle), stroke.color),
                    None => Ok(()),
                }
            }
            Self::Point(marker, color) => marker.draw(canvas, (left + SAMPLE / 2.0, middle), color),
            Self::Bar(color, index) => {
                canvas.bar(Rect { left, top: middle - 6.0, right, bottom: middle + 6.0 }, color, index)
            }
            Self::Beyond => canvas.beyond((left + SAMPLE / 2.0, middle - 4.5), true, Color::INK),
            Self::Patch(color) => {
                let patch = Rect { left, top: middle - 6.0, right, bottom: middle + 6.0 };
                canvas.rect(patch, color)?;
                canvas.border(patch, Stroke::solid(color.mix(Color::INK, 0.35), 0.5))
            }
            Self::Ramp(color, width) => {
                let pieces = 7;
                let at = |k: usize| left + SAMPLE * k as f64 / pieces as f64;
                (0..pieces).try_for_each(|k| {
                    let shade = color.shade(k as f64 / (pieces - 1) as f64);
                    let piece = [(at(k), middle), (at(k + 1), middle)];
                    canvas.line(&piece, Stroke::solid(shade, width))
                })
            }
            Self::Dot(color) => canvas.disk((left + SAMPLE / 2.0, middle), 4.0, color),
            Self::Heading(color) => {
                let tip = (left + 0.85 * SAMPLE, middle);
                canvas.line(&[(left + 0.15 * SAMPLE, middle), tip], Stroke::solid(color, 1.5))?;
                canvas.disk(tip, 4.0, color)
            }
            Self::Hatched => {
                let patch = Rect { left, top: middle - 6.0, right, bottom: middle + 6.0 };
                canvas.hatch(patch)?;
                canvas.border(patch, Stroke::solid(Color::GRAY, 0.5))
            }
            Self::Cross => canvas.cross((left + SAMPLE / 2.0, middle)),
            Self::Mark(marker) => marker.draw_rimmed(canvas, (left + SAMPLE / 2.0, middle)),
            Self::Arrow(length) => canvas.arrow((left, middle), (length, 0.0), Color::INK),
        }
    }
}

struct Placed {
    x: f64,
    row: usize,
    sample: Sample,
    lines: Vec<String>,
}

/// A legend laid out in rows for a given width.
pub(crate) struct Legend {
    placed: Vec<Placed>,
    rows: usize,
}

impl Legend {
    /// Lays the entries out from left to right, breaking rows and, where a name is wider than a row, the name.
    pub(crate) fn new(entries: Vec<(Sample, String)>, available: f64) -> Self {
        let mut placed: Vec<Placed> = Vec::new();
        let (mut x, mut row, mut row_height) = (0.0, 0, 0);
        for (sample, name) in entries {
            let sample_room = sample.width() + GAP;
            let room = available - sample_room;
            let lines = text::wrap(&name, room, SIZE, false, MAX_LINES);
            if lines.is_empty() {
                continue;
            }
            let widest = lines.iter().map(|l| text::width(l, SIZE, false)).fold(0.0, f64::max);
            let width = sample_room + widest;
            if x > 0.0 && x + width > available {
                (x, row, row_height) = (0.0, row + row_height, 0);
            }
            row_height = row_height.max(lines.len());
            placed.push(Placed { x, row, sample, lines });
            x += width + BETWEEN;
        }
        let rows = row + row_height;
        Self { placed, rows }
    }

    /// Height in pixels; 0 without entries.
    pub(crate) fn height(&self) -> f64 {
        self.rows as f64 * ROW
    }

    pub(crate) fn draw(&self, canvas: &Canvas, left: f64, top: f64) -> Result<()> {
        for entry in &self.placed {
            let x = left + entry.x;
            for (k, line) in entry.lines.iter().enumerate() {
                let middle = top + (entry.row + k) as f64 * ROW + ROW / 2.0;
                if k == 0 {
                    entry.sample.draw(canvas, x, middle)?;
                }
                let base = middle + 0.36 * SIZE;
                canvas.text(line, (x + entry.sample.width() + GAP, base), Align::Left, Look::PLAIN)?;
            }
        }
        Ok(())
    }
}
