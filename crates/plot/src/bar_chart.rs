//! Grouped bars.

use crate::axes::{Axes, Title, tick_width};
use crate::canvas::{Align, Canvas, Look, Rect, Stroke, paint};
use crate::color::Color;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result, check_finite, check_lengths};
use crate::legend::{Legend, Sample};
use crate::reading::{self, with_unit};
use crate::role::Role;
use crate::setters::setters;
use crate::stack::{BORDER, RIGHT, WIDTH};
use crate::text::{self, LEADING, SIZE};
use crate::ticks::{Scale, padded_range, three_digits};

const LINE: f64 = SIZE * LEADING;
/// Height of the frame.
const PLOT_HEIGHT: f64 = 320.0;
/// Height in pixels that vertical names may take.
const UPRIGHT_ROOM: f64 = 200.0;

/// Groups of bars: one group per category, one bar per series in each.
///
/// ```
/// use bracketry_plot::BarChart;
/// let drawing = BarChart::new("dimension", ["1", "2", "3"])
///     .series("sliding", [3.0, 5.0, 7.0])
///     .series("sticking", [2.0, 2.0, 2.0])
///     .category_label("bracket length")
///     .draw()?;
/// assert!(drawing.svg().contains("bracket length"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct BarChart {
    /// Title; empty for none.
    pub title: String,
    /// Label of the vertical axis, with its unit.
    pub value_label: String,
    /// Label below the categories; empty for none.
    pub category_label: String,
    /// Names of the groups, from left to right.
    pub categories: Vec<String>,
    /// Name and values of each series, one value for each category.
    pub series: Vec<(String, Vec<f64>)>,
    /// Color of each series; `None` takes the next one of [`Color::series`].
    pub colors: Vec<Option<Color>>,
}

impl BarChart {
    /// A chart without bars.
    pub fn new<S: Into<String>>(value_label: impl Into<String>, categories: impl IntoIterator<Item = S>) -> Self {
        Self {
            title: String::new(),
            value_label: value_label.into(),
            category_label: String::new(),
            categories: categories.into_iter().map(Into::into).collect(),
            series: Vec::new(),
            colors: Vec::new(),
        }
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
        /// Sets the label below the categories.
        category_label(label: impl Into<String>) |it| it.category_label = label.into();
    }

    /// Adds one bar to each group.
    #[must_use]
    pub fn series(mut self, name: impl Into<String>, values: impl Into<Vec<f64>>) -> Self {
        self.series.push((name.into(), values.into()));
        self.colors.push(None);
        self
    }

    /// Gives the bars added last the color of a role.
    #[must_use]
    pub fn role(mut self, role: Role) -> Self {
        if let Some(last) = self.colors.last_mut() {
            *last = Some(role.color());
        }
        self
    }

    fn color(&self, index: usize) -> Color {
        self.colors.get(index).copied().flatten().unwrap_or_else(|| Color::series(index))
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without categories; a series whose length is not the number of categories; a
    /// value that is not finite.
    pub fn draw(&self) -> Result<Drawing> {
        if self.categories.is_empty() {
            return Err(PlotError::NoContent { missing: "category" });
        }
        for (name, values) in &self.series {
            check_lengths(name, self.categories.len(), values.len())?;
            check_finite(name, values)?;
        }
        let values = || self.series.iter().flat_map(|s| s.1.iter().copied());
        let (low, high) = padded_range(values().chain([0.0]), 0.08);
        // Bars stand on zero: no room beyond it unless values lie there.
        let low = if values().any(|v| v < 0.0) { low } else { 0.0 };
        let y = Scale::new(low, high, PLOT_HEIGHT / 45.0, false);

        let label = text::wrap_label(&y.label(&self.value_label), PLOT_HEIGHT);
        let label_gap = tick_width(&y) + 8.0;
        let left = BORDER + label_gap + label.len() as f64 * LINE;
        let right = WIDTH - RIGHT;
        let slot = (right - left) / self.categories.len() as f64;
        let names = Names::new(&self.categories, slot);
        let below = text::wrap(&self.category_label, right - left, SIZE, false, 3);

        let entry = |(k, s): (usize, &(String, Vec<f64>))| (Sample::Bar(self.color(k), k), s.0.clone());
        let legend = Legend::new(self.series.iter().enumerate().map(entry).collect(), right - left);
        let title = Title::figure(&self.title, right - BORDER);
        let legend_top = BORDER + title.height();
        let top = legend_top + legend.height() + 4.0;
        let rect = Rect { left, top, right, bottom: top + PLOT_HEIGHT };
        let names_top = rect.bottom + 0.5 * SIZE;
        let height = names_top + names.room + below.len() as f64 * LINE + BORDER;
        let x = Scale { low: 0.0, high: self.categories.len() as f64, ticks: Vec::new(), factor: String::new() };
        let axes = Axes { rect, x, y };
        let bar = (0.8 * slot / self.series.len().max(1) as f64).min(70.0);

        paint(WIDTH, height, |canvas| {
            title.draw(canvas, BORDER, BORDER)?;
            legend.draw(canvas, left, legend_top)?;
            axes.grid_y(canvas)?;
            for group in 0..self.categories.len() {
                self.draw_group(canvas, &axes, group, bar)?;
                names.draw(canvas, group, (axes.page_x(group as f64 + 0.5), names_top))?;
            }
            let zero = axes.page_y(0.0);
            canvas.line(&[(left, zero), (right, zero)], Stroke::solid(Color::INK, 1.0))?;
            for (k, text) in below.iter().enumerate() {
                let base = names_top + names.room + (k as f64 + 0.9) * LINE;
                canvas.text(text, (f64::midpoint(left, right), base), Align::Center, Look::PLAIN)?;
            }
            axes.frame(canvas)?;
            axes.label_left(canvas, &label, label_gap)
        })
    }

    /// The bars of a category, each this wide.
    fn draw_group(&self, canvas: &Canvas, axes: &Axes, group: usize, bar: f64) -> Result<()> {
        // Values stand on the bars if all of them have room.
        let mut all = self.series.iter().flat_map(|s| &s.1);
        let labeled = all.all(|v| text::width(&three_digits(*v), SIZE, false) <= bar);
        let (zero, center) = (axes.page_y(0.0), axes.page_x(group as f64 + 0.5));
        let first = center - bar * self.series.len() as f64 / 2.0;
        for (k, (name, values)) in self.series.iter().enumerate() {
            let end = axes.page_y(values[group]);
            let left = first + k as f64 * bar;
            let (top, bottom) = (end.min(zero), end.max(zero));
            let body = Rect { left: left + 0.04 * bar, top, right: left + 0.96 * bar, bottom };
            canvas.bar(body, self.color(k), k)?;
            // A short bar is found all over its column.
            let column = Rect { top: axes.rect.top, bottom: axes.rect.bottom, ..body };
            let said = [self.categories[group].as_str(), name].join(" ");
            reading::value(
                canvas,
                column,
                &format!("{}: {}", said.trim(), with_unit(&self.value_label, values[group])),
            );
            if labeled {
                let base = if values[group] < 0.0 { end + 0.95 * SIZE } else { end - 4.0 };
                canvas.text(&three_digits(values[group]), (left + bar / 2.0, base), Align::Center, Look::PLAIN)?;
            }
        }
        Ok(())
    }
}

/// Names below the groups, vertical where their words do not fit side by side.
struct Names {
    lines: Vec<Vec<String>>,
    upright: bool,
    room: f64,
}

impl Names {
    fn new(names: &[String], slot: f64) -> Self {
        let too_wide = |word: &str| text::width(word, SIZE, false) > slot - 6.0;
        let upright = names.iter().any(|name| name.split_whitespace().any(too_wide));
        let (available, max_lines) = if upright { (UPRIGHT_ROOM, 1) } else { (slot - 6.0, 3) };
        let lines: Vec<Vec<String>> =
            names.iter().map(|name| text::wrap(name, available, SIZE, false, max_lines)).collect();
        let room = if upright {
            lines.iter().flatten().map(|n| text::width(n, SIZE, false)).fold(0.0, f64::max) + 0.5 * LINE
        } else {
            lines.iter().map(Vec::len).max().unwrap_or(0) as f64 * LINE
        };
        Self { lines, upright, room }
    }

    fn draw(&self, canvas: &Canvas, group: usize, (center, top): (f64, f64)) -> Result<()> {
        let upright = Look { upright: true, ..Look::PLAIN };
        self.lines[group].iter().enumerate().try_for_each(|(k, text)| {
            if self.upright {
                return canvas.text(text, (center + 0.36 * SIZE, top), Align::Right, upright);
            }
            canvas.text(text, (center, top + (k as f64 + 0.8) * LINE), Align::Center, Look::PLAIN)
        })
    }
}
