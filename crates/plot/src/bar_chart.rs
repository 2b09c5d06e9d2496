//! Grouped bars.

use crate::axes::{Axes, Title, tick_width};
use crate::canvas::{Align, Look, Rect, Stroke, paint};
use crate::color::Color;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result, check_finite, check_lengths};
use crate::legend::{Legend, Sample};
use crate::role::Role;
use crate::setters::setters;
use crate::stack::{BORDER, RIGHT, WIDTH};
use crate::text::{self, LEADING, SIZE};
use crate::ticks::{Scale, padded_range, three_digits};

/// Height in pixels that names turned upright may take.
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
    /// Colour of each series; `None` takes the next one of [`Color::series`].
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

    /// Gives the bars added last the colour of a role.
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
        let plot_height = 320.0;
        let values = self.series.iter().flat_map(|s| s.1.iter().copied());
        let (low, high) = padded_range(values.chain([0.0]), 0.08);
        // Bars stand on zero: no room beyond it unless values lie there.
        let low = if self.series.iter().any(|s| s.1.iter().any(|v| *v < 0.0)) { low } else { 0.0 };
        let y = Scale::new(low, high, plot_height / 45.0, false);

        let label = text::wrap_label(&y.label(&self.value_label), plot_height);
        let label_gap = tick_width(&y) + 8.0;
        let left = BORDER + label_gap + label.len() as f64 * SIZE * LEADING;
        let right = WIDTH - RIGHT;
        let slot = (right - left) / self.categories.len() as f64;
        let line = SIZE * LEADING;
        // Names whose words do not fit side by side are turned upright.
        let too_wide = |word: &str| text::width(word, SIZE, false) > slot - 6.0;
        let upright = self.categories.iter().any(|c| c.split_whitespace().any(too_wide));
        let (available, max_lines) = if upright { (UPRIGHT_ROOM, 1) } else { (slot - 6.0, 3) };
        let names: Vec<Vec<String>> =
            self.categories.iter().map(|c| text::wrap(c, available, SIZE, false, max_lines)).collect();
        let names_room = if upright {
            names.iter().flatten().map(|n| text::width(n, SIZE, false)).fold(0.0, f64::max) + 0.5 * line
        } else {
            names.iter().map(Vec::len).max().unwrap_or(0) as f64 * line
        };
        let below = text::wrap(&self.category_label, right - left, SIZE, false, 3);

        let entry = |(k, s): (usize, &(String, Vec<f64>))| (Sample::Bar(self.color(k), k), s.0.clone());
        let legend = Legend::new(self.series.iter().enumerate().map(entry).collect(), right - left);
        let title = Title::figure(&self.title, right - BORDER);
        let legend_top = BORDER + title.height();
        let top = legend_top + legend.height() + 4.0;
        let rect = Rect { left, top, right, bottom: top + plot_height };
        let height = rect.bottom + 0.5 * SIZE + names_room + below.len() as f64 * line + BORDER;
        let axes = Axes {
            rect,
            x: Scale { low: 0.0, high: self.categories.len() as f64, ticks: Vec::new(), factor: String::new() },
            y,
        };
        let bar = (0.8 * slot / self.series.len().max(1) as f64).min(70.0);
        // Values stand on the bars if all of them have room.
        let mut all = self.series.iter().flat_map(|s| &s.1);
        let label_bars = all.all(|v| text::width(&three_digits(*v), SIZE, false) <= bar);
        let group = bar * self.series.len() as f64;

        paint(WIDTH, height, |canvas| {
            title.draw(canvas, BORDER, BORDER)?;
            legend.draw(canvas, left, legend_top)?;
            axes.grid_y(canvas)?;
            let zero = axes.page_y(0.0);
            for (g, lines) in names.iter().enumerate() {
                let center = axes.page_x(g as f64 + 0.5);
                for (k, (_, values)) in self.series.iter().enumerate() {
                    let end = axes.page_y(values[g]);
                    let bar_left = center - group / 2.0 + k as f64 * bar;
                    let body = Rect {
                        left: bar_left + 0.04 * bar,
                        top: end.min(zero),
                        right: bar_left + 0.96 * bar,
                        bottom: end.max(zero),
                    };
                    canvas.bar(body, self.color(k), k)?;
                    if label_bars {
                        let value = three_digits(values[g]);
                        let base = if values[g] < 0.0 { end + 0.95 * SIZE } else { end - 4.0 };
                        canvas.text(&value, (bar_left + bar / 2.0, base), Align::Center, Look::PLAIN)?;
                    }
                }
                for (k, text) in lines.iter().enumerate() {
                    let top = rect.bottom + 0.5 * SIZE;
                    if upright {
                        let look = Look { upright: true, ..Look::PLAIN };
                        canvas.text(text, (center + 0.36 * SIZE, top), Align::Right, look)?;
                    } else {
                        let base = top + (k as f64 + 0.8) * line;
                        canvas.text(text, (center, base), Align::Center, Look::PLAIN)?;
                    }
                }
            }
            canvas.line(&[(left, zero), (right, zero)], Stroke::solid(Color::INK, 1.0))?;
            for (k, text) in below.iter().enumerate() {
                let base = rect.bottom + 0.5 * SIZE + names_room + (k as f64 + 0.9) * line;
                let middle = f64::midpoint(left, right);
                canvas.text(text, (middle, base), Align::Center, Look::PLAIN)?;
            }
            axes.frame(canvas)?;
            axes.label_left(canvas, &label, label_gap)
        })
    }
}
