//! Estimates with their intervals, one row for each.

use crate::axes::{Axes, TICK_ROOM, Title, horizontal_scale};
use crate::canvas::{Align, Look, Rect, Stroke, paint};
use crate::color::Color;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result, check_finite, check_interval};
use crate::legend::{Legend, Marker, Sample};
use crate::reading::{self, with_unit};
use crate::setters::setters;
use crate::stack::{BORDER, LEGEND_GAP, RIGHT, WIDTH};
use crate::text::{self, LEADING, SIZE};
use crate::ticks::{Scale, padded_range, three_digits};

/// Height of a row in pixels.
const ROW: f64 = 26.0;
/// Half the height of an interval's ends.
const END: f64 = 5.0;
/// Most of the width that names may take.
const NAMES: f64 = 0.5;

/// A named estimate.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimated {
    /// Name at the left.
    pub name: String,
    /// The estimate.
    pub value: f64,
    /// The ends of its interval, if it has one.
    pub interval: Option<(f64, f64)>,
    /// The category that gives it color and marker.
    pub category: String,
}

/// Rows of estimates with their intervals over one horizontal axis, from top to bottom in the order in which they were added.
///
/// ```
/// use bracketry_plot::IntervalChart;
/// let drawing = IntervalChart::new("share of the error explained")
///     .row("viscous friction", 0.93, Some((0.9, 0.95)), "cause")
///     .row("quadratic drag", 0.61, Some((0.5, 0.7)), "tried")
///     .draw()?;
/// assert!(drawing.svg().contains("viscous friction"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct IntervalChart {
    /// Title; empty for none.
    pub title: String,
    /// Label of the axis, with its unit.
    pub value_label: String,
    /// The rows.
    pub rows: Vec<Estimated>,
    /// Categories that have a color and marker of their own whether or not a row has them, so that these mean the same in all
    /// figures. Others follow, in the order of their first rows.
    pub known: Vec<String>,
}

impl IntervalChart {
    /// A chart without rows.
    pub fn new(value_label: impl Into<String>) -> Self {
        Self { title: String::new(), value_label: value_label.into(), rows: Vec::new(), known: Vec::new() }
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
    }

    /// Sets the categories that keep their color and marker whatever the rows are.
    #[must_use]
    pub fn categories<S: Into<String>>(mut self, known: impl IntoIterator<Item = S>) -> Self {
        self.known = known.into_iter().map(Into::into).collect();
        self
    }

    setters! {
        /// Adds a row below the others.
        row(name: impl Into<String>, value: f64, interval: Option<(f64, f64)>, category: impl Into<String>) |it|
            it.rows.push(Estimated { name: name.into(), value, interval, category: category.into() });
    }

    /// The known categories, then the others in the order of their first rows.
    fn all_categories(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.known.iter().map(String::as_str).collect();
        for row in &self.rows {
            if !names.contains(&row.category.as_str()) {
                names.push(&row.category);
            }
        }
        names
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without rows; a value that is not finite; an interval whose ends are exchanged.
    pub fn draw(&self) -> Result<Drawing> {
        if self.rows.is_empty() {
            return Err(PlotError::NoContent { missing: "row" });
        }
        for row in &self.rows {
            check_finite(&row.name, &[row.value])?;
            if let Some((low, high)) = row.interval {
                check_interval(&row.name, low, high)?;
            }
        }
        let room = NAMES * WIDTH;
        let names: Vec<String> = self.rows.iter().map(|r| text::wrap(&r.name, room, SIZE, false, 1).concat()).collect();
        let widest = names.iter().map(|n| text::width(n, SIZE, false)).fold(0.0, f64::max);
        let left = BORDER + widest + 12.0;
        let right = WIDTH - RIGHT;
        let values = self.rows.iter().flat_map(|r| {
            let (low, high) = r.interval.unwrap_or((r.value, r.value));
            [r.value, low, high]
        });
        let x = horizontal_scale(padded_range(values.chain([0.0]), 0.04), right - left, 90.0, false);

        let categories = self.all_categories();
        let sample = |k: usize| Sample::Point(Marker::series(k), Color::series(k));
        let used = categories.iter().enumerate().filter(|(_, name)| self.rows.iter().any(|r| r.category == **name));
        let entries = used.map(|(k, name)| (sample(k), (*name).to_owned())).collect();
        let legend = Legend::new(entries, right - BORDER);
        let title = Title::figure(&self.title, right - BORDER);
        let label = text::wrap(&x.label(&self.value_label), right - left, SIZE, false, 3);
        let legend_top = BORDER + title.height();
        let top = legend_top + legend.height() + LEGEND_GAP;
        let rect = Rect { left, top, right, bottom: top + ROW * self.rows.len() as f64 };
        let axes = Axes { rect, x, y: Scale { low: 0.0, high: 1.0, ticks: Vec::new(), factor: String::new() } };
        let height = rect.bottom + TICK_ROOM + label.len() as f64 * SIZE * LEADING + BORDER;

        paint(WIDTH, height, |canvas| {
            title.draw(canvas, BORDER, BORDER)?;
            legend.draw(canvas, BORDER, legend_top)?;
            axes.grid_x(canvas)?;
            let zero = axes.page_x(0.0);
            canvas.line(&[(zero, rect.top), (zero, rect.bottom)], Stroke::solid(Color::GRAY, 1.0))?;
            for (k, (row, name)) in self.rows.iter().zip(&names).enumerate() {
                let y = rect.top + (k as f64 + 0.5) * ROW;
                let category = categories.iter().position(|c| *c == row.category).unwrap_or(0);
                let color = Color::series(category);
                if let Some((low, high)) = row.interval {
                    let (a, b) = (axes.page_x(low), axes.page_x(high));
                    let stroke = Stroke::solid(color, 1.75);
                    canvas.line(&[(a, y), (b, y)], stroke)?;
                    canvas.line(&[(a, y - END), (a, y + END)], stroke)?;
                    canvas.line(&[(b, y - END), (b, y + END)], stroke)?;
                }
                Marker::series(category).draw(canvas, (axes.page_x(row.value), y), color)?;
                canvas.text(name, (left - 8.0, y + 0.36 * SIZE), Align::Right, Look::PLAIN)?;
            }
            for (k, row) in self.rows.iter().enumerate() {
                let top = rect.top + k as f64 * ROW;
                let said = match row.interval {
                    Some((low, high)) => format!(
                        "{} ({} … {})",
                        with_unit(&self.value_label, row.value),
                        three_digits(low),
                        three_digits(high)
                    ),
                    None => with_unit(&self.value_label, row.value),
                };
                let said = format!("{}: {said}, {}", row.name, row.category);
                reading::value(canvas, Rect { top, bottom: top + ROW, ..rect }, &said);
            }
            axes.frame(canvas)?;
            axes.label_below(canvas, &label)
        })
    }
}
