//! What figures over two quantities have in common: places on a grid, color bar, marks, layout.

use crate::axes::{Axes, TICK_ROOM, Title, horizontal_scale, tick_width};
use crate::canvas::{Align, Canvas, Look, Rect, Stroke, paint};
use crate::color::Color;
use crate::color_map::ColorMap;
use crate::drawing::Drawing;
use crate::error::{Result, check_finite, check_increasing};
use crate::legend::{Legend, Marker, Sample};
use crate::reading;
use crate::stack::{BORDER, LEGEND_GAP, RIGHT, WIDTH};
use crate::text::{self, LEADING, SIZE};
use crate::ticks::{Scale, padded_range};

const LINE: f64 = SIZE * LEADING;
/// Height of the frame.
const HEIGHT: f64 = 400.0;
/// Width of the color bar and its distance from the frame.
const BAR: f64 = 18.0;
const BAR_GAP: f64 = 18.0;
/// Distance of the bar's tick labels from it.
const TICK_GAP: f64 = 8.0;

/// A place to be pointed out.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// Name in the legend, which lists every name once; marks of one name look alike.
    pub name: String,
    /// Position on the horizontal axis.
    pub x: f64,
    /// Position on the vertical axis.
    pub y: f64,
}

impl Mark {
    /// The place `(x, y)`, called `name` in the legend.
    pub fn new(name: impl Into<String>, x: f64, y: f64) -> Self {
        Self { name: name.into(), x, y }
    }
}

/// Names of the two axes and of the figure.
#[derive(Debug, Clone)]
pub(crate) struct Labels {
    pub(crate) title: String,
    pub(crate) x: String,
    pub(crate) y: String,
}

/// The places of cells: each reaches half way to its neighbors.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    pub(crate) x: Vec<f64>,
    pub(crate) y: Vec<f64>,
}

impl Cells {
    pub(crate) fn check(&self, labels: &Labels) -> Result<()> {
        check_increasing(&labels.x, &self.x)?;
        check_increasing(&labels.y, &self.y)
    }

    /// Borders of the columns and of the rows.
    pub(crate) fn edges(&self) -> (Vec<f64>, Vec<f64>) {
        (edges(&self.x), edges(&self.y))
    }
}

/// Half way between neighbors, and as far beyond the first and the last.
fn edges(centers: &[f64]) -> Vec<f64> {
    let n = centers.len();
    if n < 2 {
        let (low, high) = padded_range(centers.iter().copied(), 0.0);
        return vec![low, high];
    }
    let inner = centers.windows(2).map(|w| f64::midpoint(w[0], w[1]));
    let first = centers[0] - 0.5 * (centers[1] - centers[0]);
    let last = centers[n - 1] + 0.5 * (centers[n - 1] - centers[n - 2]);
    std::iter::once(first).chain(inner).chain([last]).collect()
}

/// Colors for the values between two ends, and what they are called.
#[derive(Debug, Clone)]
pub(crate) struct ColorScale {
    pub(crate) label: String,
    pub(crate) map: ColorMap,
    low: f64,
    high: f64,
    /// Whether values lie beyond the set range.
    below: bool,
    above: bool,
}

impl ColorScale {
    /// The scale of these values, over `range` if one is set.
    pub(crate) fn new(
        label: &str,
        map: ColorMap,
        range: Option<(f64, f64)>,
        values: impl Iterator<Item = f64>,
    ) -> Self {
        let (least, most) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = match (range, map) {
            (Some(set), _) => padded_range([set.0, set.1], 0.0),
            (None, map) if map.is_diverging() && least <= most => {
                let size = least.abs().max(most.abs());
                padded_range([-size, size], 0.0)
            }
            (None, _) => padded_range([least, most].into_iter().filter(|v| v.is_finite()), 0.0),
        };
        let (below, above) = (least < low, most > high && most.is_finite());
        Self { label: label.to_owned(), map, low, high, below, above }
    }

    pub(crate) fn color(&self, value: f64) -> Color {
        self.map.color((value - self.low) / (self.high - self.low))
    }

    fn ticks(&self) -> Scale {
        Scale::new(self.low, self.high, HEIGHT / 60.0, false)
    }

    /// Tick labels; those at the ends say when values beyond them have the same color.
    fn tick_label(&self, value: f64, text: &str) -> String {
        let close = |end: f64| (value - end).abs() <= 1e-9 * (self.high - self.low);
        match () {
            () if self.above && close(self.high) => format!("≥ {text}"),
            () if self.below && close(self.low) => format!("≤ {text}"),
            () => text.to_owned(),
        }
    }

    /// Room right of the frame.
    fn room(&self) -> f64 {
        let scale = self.ticks();
        let labels = scale.ticks.iter().map(|(v, text)| self.tick_label(*v, text));
        let widest = labels.map(|t| text::width(&t, SIZE, false)).fold(0.0, f64::max);
        let label = if self.label.is_empty() { 0.0 } else { self.label_lines().len() as f64 * LINE + 4.0 };
        BAR_GAP + BAR + TICK_GAP + widest + label + BORDER
    }

    fn label_lines(&self) -> Vec<String> {
        text::wrap_label(&self.ticks().label(&self.label), HEIGHT)
    }

    fn draw(&self, canvas: &Canvas, frame: Rect) -> Result<()> {
        const SHADES: usize = 128;
        let bar = Rect { left: frame.right + BAR_GAP, right: frame.right + BAR_GAP + BAR, ..frame };
        for k in 0..SHADES {
            let at = |k: usize| bar.bottom - bar.height() * k as f64 / SHADES as f64;
            let shade = self.map.color((k as f64 + 0.5) / SHADES as f64);
            // A trifle taller, so that no white shines through.
            let top = (at(k + 1) - 0.4).max(bar.top);
            canvas.rect(Rect { top, bottom: at(k), ..bar }, shade)?;
        }
        let scale = self.ticks();
        let stroke = Stroke::solid(Color::INK, 1.0);
        let mut widest = 0.0f64;
        for (value, label) in &scale.ticks {
            let y = bar.bottom - scale.fraction(*value) * bar.height();
            canvas.line(&[(bar.right, y), (bar.right + 5.0, y)], stroke)?;
            let label = self.tick_label(*value, label);
            widest = widest.max(text::width(&label, SIZE, false));
            canvas.text(&label, (bar.right + TICK_GAP, y + 0.365 * SIZE), Align::Left, Look::PLAIN)?;
        }
        canvas.border(bar, stroke)?;
        let upright = Look { upright: true, ..Look::PLAIN };
        for (k, line) in self.label_lines().iter().enumerate() {
            let base = bar.right + TICK_GAP + widest + 4.0 + (k as f64 + 0.75) * LINE;
            canvas.text(line, (base, f64::midpoint(bar.top, bar.bottom)), Align::Center, upright)?;
        }
        Ok(())
    }
}

/// A figure over two quantities, ready to be laid out.
pub(crate) struct Field<'a> {
    pub(crate) labels: &'a Labels,
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
    pub(crate) scale: Option<&'a ColorScale>,
    /// Legend, without the marks.
    pub(crate) entries: Vec<(Sample, String)>,
    pub(crate) marks: &'a [Mark],
    /// Whether grid lines are drawn.
    pub(crate) grid: bool,
}

impl Field<'_> {
    /// Room for the frame beside this color scale: its width and height in pixels. The width left of it, which depends
    /// on the tick labels, is that of `y`.
    pub(crate) fn frame(&self) -> Rect {
        let y = self.y_scale();
        let left = BORDER + tick_width(&y) + 8.0 + self.y_label().len() as f64 * LINE;
        let right = WIDTH - self.scale.map_or(RIGHT, ColorScale::room);
        Rect { left, top: 0.0, right, bottom: HEIGHT }
    }

    fn y_scale(&self) -> Scale {
        Scale::new(self.y.0, self.y.1, HEIGHT / 60.0 + 1.0, false)
    }

    fn y_label(&self) -> Vec<String> {
        text::wrap_label(&self.y_scale().label(&self.labels.y), HEIGHT)
    }

    /// Names of the marks, in the order in which they occur.
    fn mark_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for mark in self.marks {
            if !names.contains(&mark.name.as_str()) {
                names.push(&mark.name);
            }
        }
        names
    }

    /// Draws axes, legend and color bar around what `content` draws.
    pub(crate) fn draw(&self, content: impl Fn(&Canvas, &Axes) -> Result<()>) -> Result<Drawing> {
        for mark in self.marks {
            check_finite(&mark.name, &[mark.x, mark.y])?;
        }
        let Rect { left, right, .. } = self.frame();
        let y = self.y_scale();
        let x = horizontal_scale(self.x, right - left, 85.0, false);
        let x_label = text::wrap(&x.label(&self.labels.x), right - left, SIZE, false, 3);
        let title = Title::figure(&self.labels.title, WIDTH - BORDER - RIGHT);
        let names = self.mark_names();
        let marks = names.iter().enumerate().map(|(k, name)| (Sample::Mark(Marker::series(k)), (*name).to_owned()));
        let legend = Legend::new(self.entries.iter().cloned().chain(marks).collect(), WIDTH - left - BORDER);
        let top = BORDER + title.height() + legend.height() + LEGEND_GAP;
        let rect = Rect { left, top, right, bottom: top + HEIGHT };
        let height = rect.bottom + TICK_ROOM + x_label.len().max(1) as f64 * LINE + BORDER;
        let axes = Axes { rect, x, y };
        paint(WIDTH, height, |canvas| {
            title.draw(canvas, BORDER, BORDER)?;
            legend.draw(canvas, left, BORDER + title.height())?;
            if self.grid {
                axes.grid_x(canvas)?;
                axes.grid_y(canvas)?;
            }
            content(canvas, &axes)?;
            for mark in self.marks {
                let kind = names.iter().position(|n| *n == mark.name).unwrap_or(0);
                let (x, y) = axes.page((mark.x, mark.y));
                if (rect.left..=rect.right).contains(&x) && (rect.top..=rect.bottom).contains(&y) {
                    Marker::series(kind).draw_rimmed(canvas, (x, y))?;
                }
            }
            reading::panel(canvas, 0, &axes, (&self.labels.x, &self.labels.y));
            axes.frame(canvas)?;
            axes.label_left(canvas, &self.y_label(), tick_width(&axes.y) + 8.0)?;
            axes.label_below(canvas, &x_label)?;
            self.scale.map_or(Ok(()), |scale| scale.draw(canvas, rect))
        })
    }
}
