//! The frame of a plot: grid, ticks, labels and the map from data to the page.

use crate::canvas::{Align, Canvas, Look, Rect, Stroke};
use crate::color::Color;
use crate::error::Result;
use crate::text::{self, LEADING, SIZE, TITLE_SIZE};
use crate::ticks::Scale;

const TICK: f64 = 5.0;
/// Distance of tick labels from their axis.
const TICK_GAP: f64 = 8.0;
const LINE: f64 = SIZE * LEADING;
/// Height of capitals and figures of the font, in em.
const CAP: f64 = 0.73;

/// The height below a frame that tick labels take.
pub(crate) const TICK_ROOM: f64 = TICK_GAP + LINE;

/// A plot's place on the page and its two scales.
pub(crate) struct Axes {
    pub(crate) rect: Rect,
    pub(crate) x: Scale,
    pub(crate) y: Scale,
}

impl Axes {
    pub(crate) fn page_x(&self, x: f64) -> f64 {
        self.rect.left + self.x.fraction(x) * self.rect.width()
    }

    pub(crate) fn page_y(&self, y: f64) -> f64 {
        self.rect.bottom - self.y.fraction(y) * self.rect.height()
    }

    pub(crate) fn page(&self, point: (f64, f64)) -> (f64, f64) {
        (self.page_x(point.0), self.page_y(point.1))
    }

    pub(crate) fn grid_x(&self, canvas: &Canvas) -> Result<()> {
        self.x.ticks.iter().try_for_each(|(v, _)| {
            let x = self.page_x(*v);
            canvas.line(&[(x, self.rect.top), (x, self.rect.bottom)], grid())
        })
    }

    pub(crate) fn grid_y(&self, canvas: &Canvas) -> Result<()> {
        self.y.ticks.iter().try_for_each(|(v, _)| {
            let y = self.page_y(*v);
            canvas.line(&[(self.rect.left, y), (self.rect.right, y)], grid())
        })
    }

    /// The border with its tick marks, over the data.
    pub(crate) fn frame(&self, canvas: &Canvas) -> Result<()> {
        let r = self.rect;
        let stroke = Stroke::solid(Color::INK, 1.0);
        for (v, _) in &self.x.ticks {
            let x = self.page_x(*v);
            canvas.line(&[(x, r.bottom), (x, r.bottom + TICK)], stroke)?;
        }
        for (v, _) in &self.y.ticks {
            let y = self.page_y(*v);
            canvas.line(&[(r.left - TICK, y), (r.left, y)], stroke)?;
        }
        canvas.border(r, stroke)
    }

    /// Tick labels and axis label on the left, the label `label_gap` pixels from the frame.
    pub(crate) fn label_left(&self, canvas: &Canvas, label: &[String], label_gap: f64) -> Result<()> {
        let r = self.rect;
        for (v, text) in &self.y.ticks {
            let base = self.page_y(*v) + CAP / 2.0 * SIZE;
            canvas.text(text, (r.left - TICK_GAP, base), Align::Right, Look::PLAIN)?;
        }
        let upright = Look { upright: true, ..Look::PLAIN };
        for (k, line) in label.iter().rev().enumerate() {
            let base = r.left - label_gap - 0.25 * SIZE - k as f64 * LINE;
            let middle = f64::midpoint(r.top, r.bottom);
            canvas.text(line, (base, middle), Align::Center, upright)?;
        }
        Ok(())
    }

    /// Tick labels and axis label below.
    pub(crate) fn label_below(&self, canvas: &Canvas, label: &[String]) -> Result<()> {
        let r = self.rect;
        let base = r.bottom + TICK_GAP + 0.9 * SIZE;
        for (v, text) in &self.x.ticks {
            canvas.text(text, (self.page_x(*v), base), Align::Center, Look::PLAIN)?;
        }
        for (k, line) in label.iter().enumerate() {
            let at = (f64::midpoint(r.left, r.right), base + (k + 1) as f64 * LINE);
            canvas.text(line, at, Align::Center, Look::PLAIN)?;
        }
        Ok(())
    }
}

fn grid() -> Stroke {
    Stroke::solid(Color(214, 214, 214), 0.75)
}

/// Room that the tick labels of a vertical scale need left of the frame.
pub(crate) fn tick_width(scale: &Scale) -> f64 {
    scale.ticks.iter().map(|t| text::width(&t.1, SIZE, false)).fold(0.0, f64::max) + TICK_GAP
}

/// The scale of a horizontal axis of `pixels` length with ticks `spacing` pixels apart, or farther where their labels
/// need more room.
pub(crate) fn horizontal_scale((low, high): (f64, f64), pixels: f64, spacing: f64, integer: bool) -> Scale {
    let mut count = pixels / spacing;
    loop {
        let scale = Scale::new(low, high, count, integer);
        let widest = scale.ticks.iter().map(|t| text::width(&t.1, SIZE, false)).fold(0.0, f64::max);
        let apart = scale.ticks.windows(2).map(|w| (w[1].0 - w[0].0) / (high - low) * pixels);
        if count < 1.0 || apart.fold(f64::INFINITY, f64::min) >= widest + 12.0 {
            return scale;
        }
        count *= 0.8;
    }
}

/// A title broken into lines, drawn left-aligned.
pub(crate) struct Title(Vec<String>, f64);

impl Title {
    pub(crate) fn figure(text: &str, available: f64) -> Self {
        Self(text::wrap(text, available, TITLE_SIZE, true, 3), TITLE_SIZE)
    }

    pub(crate) fn plot(text: &str, available: f64) -> Self {
        Self(text::wrap(text, available, SIZE, true, 3), SIZE)
    }

    pub(crate) fn height(&self) -> f64 {
        if self.0.is_empty() {
            return 0.0;
        }
        self.0.len() as f64 * self.1 * LEADING + 6.0
    }

    pub(crate) fn draw(&self, canvas: &Canvas, left: f64, top: f64) -> Result<()> {
        let look = Look { size: self.1, bold: true, upright: false };
        for (k, line) in self.0.iter().enumerate() {
            let base = top + (k as f64 * LEADING + 1.0) * self.1;
            canvas.text(line, (left, base), Align::Left, look)?;
        }
        Ok(())
    }
}
