//! Maps: a number or a category over two quantities.

use crate::axes::Axes;
use crate::canvas::{Canvas, Dash, Rect, Stroke};
use crate::color::Color;
use crate::color_map::ColorMap;
use crate::contour::contour;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result, check_finite, check_interval, check_lengths};
use crate::field::{Cells, ColorScale, Field, Labels, Mark};
use crate::legend::Sample;
use crate::panel::Level;
use crate::reading;
use crate::setters::setters;

/// A quantity over two others, as the colors of cells; cells without a value are hatched.
///
/// ```
/// use bracketry_plot::HeatMap;
/// let friction = [0.1, 0.2, 0.3];
/// let frequency = [1.0, 1.5];
/// // One row for each frequency; NaN where the target is not reached.
/// let time = [vec![4.0, 3.0, f64::NAN], vec![3.0, 2.4, 2.1]];
/// let drawing = HeatMap::new("friction coefficient μ [1]", "frequency [Hz]", "time to target [s]")
///     .values(friction, frequency, time)
///     .missing("not reached within 15 s")
///     .contour("2.5 s", 2.5)
///     .mark("published", 0.3, 1.5)
///     .draw()?;
/// assert!(drawing.svg().contains("not reached within 15 s"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct HeatMap {
    labels: Labels,
    value_label: String,
    cells: Cells,
    values: Vec<Vec<f64>>,
    missing: String,
    map: ColorMap,
    range: Option<(f64, f64)>,
    levels: Vec<Level>,
    marks: Vec<Mark>,
}

impl HeatMap {
    /// An empty map; the labels of the axes and of the color bar name quantity and unit.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>, value_label: impl Into<String>) -> Self {
        Self {
            labels: Labels { title: String::new(), x: x_label.into(), y: y_label.into() },
            value_label: value_label.into(),
            cells: Cells { x: Vec::new(), y: Vec::new() },
            values: Vec::new(),
            missing: "no value".to_owned(),
            map: ColorMap::Sequential,
            range: None,
            levels: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Sets the values: `rows[j][i]` belongs to the place `(x[i], y[j])`; a NaN is a missing value. The places
    /// increase, each cell reaches half way to its neighbors.
    #[must_use]
    pub fn values(
        mut self,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
        rows: impl IntoIterator<Item = Vec<f64>>,
    ) -> Self {
        self.cells = Cells { x: x.into(), y: y.into() };
        self.values = rows.into_iter().collect();
        self
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.labels.title = title.into();
        /// Sets what a missing value means, for the legend.
        missing(meaning: impl Into<String>) |it| it.missing = meaning.into();
        /// Sets the colors.
        color_map(map: ColorMap) |it| it.map = map;
        /// Sets the range of the colors; values beyond have the color of its end, which the color bar says. Without it
        /// the range is that of the values, symmetric about zero for [`ColorMap::Diverging`].
        range(low: f64, high: f64) |it| it.range = Some((low, high));
        /// Adds the line on which the quantity has this value, `name` in the legend.
        contour(name: impl Into<String>, level: f64) |it| it.levels.push(Level::new(name, level));
        /// Points out the place `(x, y)`.
        mark(name: impl Into<String>, x: f64, y: f64) |it| it.marks.push(Mark::new(name, x, y));
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without values, [`PlotError::Unordered`] where an axis does not increase,
    /// [`PlotError::LengthMismatch`] where rows and axes do not fit, [`PlotError::NotFinite`] for infinite values.
    pub fn draw(&self) -> Result<Drawing> {
        check_grid(&self.labels, &self.cells, &self.value_label, &self.values)?;
        for row in &self.values {
            let known: Vec<f64> = row.iter().map(|v| if v.is_nan() { 0.0 } else { *v }).collect();
            check_finite(&self.value_label, &known)?;
        }
        if let Some((low, high)) = self.range {
            check_interval(&format!("range of {}", self.value_label), low, high)?;
        }
        for level in &self.levels {
            check_finite(&level.name, &[level.value])?;
        }
        let known = || self.values.iter().flatten().copied().filter(|v| !v.is_nan());
        let scale = ColorScale::new(&self.value_label, self.map, self.range, known());
        let mut entries: Vec<(Sample, String)> = Vec::new();
        for (k, level) in self.levels.iter().enumerate() {
            entries.push((Sample::Line(contour_stroke(k), None), level.name.clone()));
        }
        if self.values.iter().flatten().any(|v| v.is_nan()) {
            entries.push((Sample::Hatched, self.missing.clone()));
        }
        let (columns, rows) = self.cells.edges();
        let field = field_of_cells(&self.labels, (&columns, &rows), &self.marks);
        Field { scale: Some(&scale), entries, ..field }.draw(|canvas, axes| {
            let fill = |i: usize, j: usize| {
                let v = self.values[j][i];
                (!v.is_nan()).then(|| scale.color(v))
            };
            draw_cells(canvas, axes, (&columns, &rows), fill, |_, _, _| ())?;
            for (k, level) in self.levels.iter().enumerate() {
                draw_contour(canvas, axes, contour(&self.cells.x, &self.cells.y, &self.values, level.value), k)?;
            }
            Ok(())
        })
    }
}

/// What happens over two quantities: a category in each cell, cells without one are hatched.
///
/// ```
/// use bracketry_plot::{Color, RegimeMap};
/// let drawing = RegimeMap::new("friction coefficient μ [1]", "frequency [Hz]")
///     .category("sticks", Color::GRAY)
///     .category("slides", Color::BLUE)
///     .cells([0.1, 0.3], [1.0, 1.5], [vec![Some(1), Some(0)], vec![Some(1), None]])
///     .missing("not run")
///     .draw()?;
/// assert!(drawing.svg().contains("sticks") && drawing.svg().contains("not run"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct RegimeMap {
    labels: Labels,
    cells: Cells,
    rows: Vec<Vec<Option<usize>>>,
    missing: String,
    categories: Vec<(String, Color)>,
    curves: Vec<Curve>,
    marks: Vec<Mark>,
}

/// The zeros of a function, by its values on a grid.
#[derive(Debug, Clone)]
struct Curve {
    name: String,
    places: Cells,
    values: Vec<Vec<f64>>,
}

impl RegimeMap {
    /// An empty map; the labels of the axes name quantity and unit.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self {
            labels: Labels { title: String::new(), x: x_label.into(), y: y_label.into() },
            cells: Cells { x: Vec::new(), y: Vec::new() },
            rows: Vec::new(),
            missing: "no value".to_owned(),
            categories: Vec::new(),
            curves: Vec::new(),
            marks: Vec::new(),
        }
    }

    /// Adds the curve on which a function vanishes, `name` in the legend; `rows[j][i]` is its value at `(x[i], y[j])`.
    #[must_use]
    pub fn curve(
        mut self,
        name: impl Into<String>,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
        rows: impl IntoIterator<Item = Vec<f64>>,
    ) -> Self {
        let places = Cells { x: x.into(), y: y.into() };
        self.curves.push(Curve { name: name.into(), places, values: rows.into_iter().collect() });
        self
    }

    setters! {
        /// Adds a category with its color; they are numbered from 0. The legend shows those that occur.
        category(name: impl Into<String>, color: Color) |it| it.categories.push((name.into(), color));
    }

    /// Sets the categories: `rows[j][i]` belongs to the place `(x[i], y[j])`. The places increase, each cell reaches
    /// half way to its neighbors.
    #[must_use]
    pub fn cells(
        mut self,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
        rows: impl IntoIterator<Item = Vec<Option<usize>>>,
    ) -> Self {
        self.cells = Cells { x: x.into(), y: y.into() };
        self.rows = rows.into_iter().collect();
        self
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.labels.title = title.into();
        /// Sets what a cell without category means, for the legend.
        missing(meaning: impl Into<String>) |it| it.missing = meaning.into();
        /// Points out the place `(x, y)`.
        mark(name: impl Into<String>, x: f64, y: f64) |it| it.marks.push(Mark::new(name, x, y));
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without cells, [`PlotError::Unordered`] where an axis does not increase,
    /// [`PlotError::LengthMismatch`] where rows and axes do not fit, [`PlotError::UnknownCategory`].
    pub fn draw(&self) -> Result<Drawing> {
        check_grid(&self.labels, &self.cells, "cells", &self.rows)?;
        let known = self.categories.len();
        let used = || self.rows.iter().flatten().copied();
        if let Some(category) = used().flatten().find(|c| *c >= known) {
            return Err(PlotError::UnknownCategory { category, known });
        }
        let occurs = |k: usize| used().flatten().any(|c| c == k);
        let occurring = self.categories.iter().enumerate().filter(|(k, _)| occurs(*k));
        let mut entries: Vec<_> = occurring.map(|(_, (name, color))| (Sample::Patch(*color), name.clone())).collect();
        if used().any(|c| c.is_none()) {
            entries.push((Sample::Hatched, self.missing.clone()));
        }
        for (k, curve) in self.curves.iter().enumerate() {
            check_grid(&self.labels, &curve.places, &curve.name, &curve.values)?;
            entries.push((Sample::Line(contour_stroke(k), None), curve.name.clone()));
        }
        let (columns, rows) = self.cells.edges();
        let field = field_of_cells(&self.labels, (&columns, &rows), &self.marks);
        Field { entries, ..field }.draw(|canvas, axes| {
            let category = |i: usize, j: usize| self.rows[j][i].map(|k| &self.categories[k]);
            draw_cells(
                canvas,
                axes,
                (&columns, &rows),
                |i, j| category(i, j).map(|c| c.1),
                |cell, i, j| {
                    reading::value(canvas, cell, category(i, j).map_or(&self.missing, |c| &c.0));
                },
            )?;
            for (k, c) in self.curves.iter().enumerate() {
                draw_contour(canvas, axes, contour(&c.places.x, &c.places.y, &c.values, 0.0), k)?;
            }
            Ok(())
        })
    }
}

fn check_grid<T>(labels: &Labels, cells: &Cells, name: &str, rows: &[Vec<T>]) -> Result<()> {
    if cells.x.is_empty() || cells.y.is_empty() {
        return Err(PlotError::NoContent { missing: "row and column of values" });
    }
    cells.check(labels)?;
    check_lengths(&format!("rows of {name}"), cells.y.len(), rows.len())?;
    rows.iter().try_for_each(|row| check_lengths(&format!("a row of {name}"), cells.x.len(), row.len()))
}

/// A figure that the cells between these borders fill.
fn field_of_cells<'a>(labels: &'a Labels, (columns, rows): (&[f64], &[f64]), marks: &'a [Mark]) -> Field<'a> {
    let ends = |edges: &[f64]| (edges[0], edges[edges.len() - 1]);
    Field { labels, x: ends(columns), y: ends(rows), scale: None, entries: Vec::new(), marks, grid: false }
}

/// Draws cells, those of one color beside each other in one piece; `None` is hatched.
fn draw_cells(
    canvas: &Canvas,
    axes: &Axes,
    (columns, rows): (&[f64], &[f64]),
    fill: impl Fn(usize, usize) -> Option<Color>,
    note: impl Fn(Rect, usize, usize),
) -> Result<()> {
    // A trifle larger to the right and downwards, where the next one covers it, so that no white shines through.
    const OVERLAP: f64 = 0.4;
    let frame = axes.rect;
    for j in (0..rows.len() - 1).rev() {
        let mut from = 0;
        for i in 0..columns.len() - 1 {
            let color = fill(i, j);
            if i + 2 < columns.len() && fill(i + 1, j) == color {
                continue;
            }
            let cell = Rect {
                left: axes.page_x(columns[from]),
                right: (axes.page_x(columns[i + 1]) + OVERLAP).min(frame.right),
                top: axes.page_y(rows[j + 1]),
                bottom: (axes.page_y(rows[j]) + OVERLAP).min(frame.bottom),
            };
            match color {
                Some(color) => canvas.rect(cell, color)?,
                None => canvas.hatch(cell)?,
            }
            note(cell, i, j);
            from = i + 1;
        }
    }
    Ok(())
}

/// A line of equal value, with a white margin.
fn draw_contour(canvas: &Canvas, axes: &Axes, pieces: Vec<[(f64, f64); 2]>, index: usize) -> Result<()> {
    let page = joined(pieces.into_iter().map(|piece| piece.map(|p| axes.page(p))).collect());
    for line in &page {
        canvas.line(line, Stroke::solid(Color(255, 255, 255), 4.0))?;
    }
    for line in &page {
        canvas.line(line, contour_stroke(index))?;
    }
    Ok(())
}

fn contour_stroke(index: usize) -> Stroke {
    Stroke { color: Color::INK, width: 1.75, dash: Dash::ALL[index % Dash::ALL.len()] }
}

/// Pieces whose ends meet, as lines.
fn joined(mut pieces: Vec<[(f64, f64); 2]>) -> Vec<Vec<(f64, f64)>> {
    const NEAR: f64 = 1e-6;
    let near = |p: (f64, f64), q: (f64, f64)| (p.0 - q.0).abs() < NEAR && (p.1 - q.1).abs() < NEAR;
    let mut lines = Vec::new();
    while let Some([a, b]) = pieces.pop() {
        let mut line = std::collections::VecDeque::from([a, b]);
        loop {
            let (first, last) = (line[0], line[line.len() - 1]);
            let touching = pieces.iter().position(|p| p.iter().any(|q| near(*q, first) || near(*q, last)));
            let Some([p, q]) = touching.map(|k| pieces.swap_remove(k)) else {
                break;
            };
            match () {
                () if near(p, last) => line.push_back(q),
                () if near(q, last) => line.push_back(p),
                () if near(p, first) => line.push_front(q),
                () => line.push_front(p),
            }
        }
        lines.push(line.into());
    }
    lines
}
