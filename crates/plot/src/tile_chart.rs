//! Grids of colored, labeled tiles: what happens in which step.

use crate::axes::Title;
use crate::canvas::{Align, Canvas, Look, Rect, Stroke, paint};
use crate::color::Color;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result};
use crate::legend::{Legend, Sample};
use crate::reading;
use crate::setters::setters;
use crate::stack::{BORDER, RIGHT, WIDTH};
use crate::text::{self, LEADING, SIZE};

const LINE: f64 = SIZE * LEADING;
/// Height of a row of tiles.
const ROW: f64 = 25.0;
/// Widest column.
const WIDEST: f64 = 190.0;
/// Room that the names of rows may take.
const NAME_ROOM: f64 = 200.0;
/// Distance between names and grid.
const GAP: f64 = 8.0;
/// Between one grid and the next.
const GRID_GAP: f64 = 22.0;
/// Labels are set smaller to fit their tile, down to this size.
const SMALLEST: f64 = 10.5;

/// A colored cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tile {
    /// Column, from 0 at the left.
    pub column: usize,
    /// Row, from 0 at the top.
    pub row: usize,
    /// Name of its category, which stands in the legend.
    pub category: String,
    /// Text on it; empty for none.
    pub label: String,
}

/// Rows and columns with names, and the tiles in them.
#[derive(Debug, Clone, Default)]
pub struct TileGrid {
    /// Stands above the grid; empty for none.
    pub title: String,
    /// Names of the columns, from left to right.
    pub columns: Vec<String>,
    /// Names of the rows, from top to bottom.
    pub rows: Vec<String>,
    /// What stands below the columns; empty for none.
    pub column_label: String,
    /// What stands upright beside the rows; empty for none.
    pub row_label: String,
    /// The tiles; where there is none the grid is white.
    pub tiles: Vec<Tile>,
}

impl TileGrid {
    /// A grid without tiles.
    pub fn new<C: Into<String>, R: Into<String>>(
        columns: impl IntoIterator<Item = C>,
        rows: impl IntoIterator<Item = R>,
    ) -> Self {
        TileGrid {
            columns: columns.into_iter().map(Into::into).collect(),
            rows: rows.into_iter().map(Into::into).collect(),
            ..TileGrid::default()
        }
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
        /// Sets what stands below the columns.
        column_label(label: impl Into<String>) |it| it.column_label = label.into();
        /// Sets what stands beside the rows.
        row_label(label: impl Into<String>) |it| it.row_label = label.into();
        /// Adds a tile.
        tile(column: usize, row: usize, category: impl Into<String>, label: impl Into<String>) |it|
            it.tiles.push(Tile { column, row, category: category.into(), label: label.into() });
    }
}

/// Grids of tiles below each other, with one legend.
///
/// ```
/// use bracketry_plot::{Color, TileChart, TileGrid};
/// let grid = TileGrid::new(["1", "2"], ["3", "2", "1"])
///     .tile(0, 2, "given", "f")
///     .tile(0, 1, "given", "g")
///     .tile(1, 0, "bracket", "[f,g]")
///     .column_label("length of the bracket")
///     .row_label("dimension");
/// let drawing = TileChart::new().category("given", Color::BLUE).grid(grid).draw()?;
/// assert!(drawing.svg().contains("[f,g]"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct TileChart {
    /// Title; empty for none.
    pub title: String,
    /// Names and colors of categories, in the order of the legend; others follow in the order in which they occur.
    pub categories: Vec<(String, Color)>,
    /// The grids, from top to bottom.
    pub grids: Vec<TileGrid>,
}

impl TileChart {
    /// A chart without grids.
    pub fn new() -> Self {
        Self::default()
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
        /// Gives a category its color and its place in the legend, which shows those that occur.
        category(name: impl Into<String>, color: Color) |it| it.categories.push((name.into(), color));
        /// Adds a grid.
        grid(grid: TileGrid) |it| it.grids.push(grid);
    }

    /// Categories that occur, with their colors.
    fn used(&self) -> Vec<(String, Color)> {
        let tiles = || self.grids.iter().flat_map(|g| &g.tiles);
        let mut used = self.categories.clone();
        used.retain(|c| tiles().any(|t| t.category == c.0));
        for t in tiles() {
            if !used.iter().any(|c| c.0 == t.category) {
                used.push((t.category.clone(), Color::band(used.len())));
            }
        }
        used
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without grids, or for one without rows or columns; [`PlotError::OutsideGrid`] for a
    /// tile that lies in none of its cells.
    pub fn draw(&self) -> Result<Drawing> {
        if self.grids.is_empty() {
            return Err(PlotError::NoContent { missing: "grid" });
        }
        for g in &self.grids {
            if g.columns.is_empty() || g.rows.is_empty() {
                return Err(PlotError::NoContent { missing: "row and column" });
            }
            if let Some(t) = g.tiles.iter().find(|t| t.column >= g.columns.len() || t.row >= g.rows.len()) {
                return Err(PlotError::OutsideGrid { column: t.column, row: t.row });
            }
        }
        let used = self.used();
        let all_rows = || self.grids.iter().flat_map(|g| &g.rows);
        let names = all_rows().map(|n| text::width(n, SIZE, false)).fold(0.0, f64::max).min(NAME_ROOM);
        let labeled = self.grids.iter().any(|g| !g.row_label.is_empty());
        let left = BORDER + names + GAP + if labeled { LINE } else { 0.0 };
        let right = WIDTH - RIGHT;
        let entries = used.iter().map(|(name, color)| (Sample::Patch(*color), name.clone())).collect();
        let legend = Legend::new(entries, WIDTH - RIGHT - BORDER);
        let title = Title::figure(&self.title, right - BORDER);
        // All grids have columns of the same width, so that equal columns stand below each other.
        let most = self.grids.iter().map(|g| g.columns.len()).max().unwrap_or(1);
        let width = ((right - left) / most as f64).min(WIDEST);
        let mut placed = Vec::new();
        let mut top = BORDER + title.height() + legend.height() + GAP;
        for g in &self.grids {
            let p = Placed::new(g, (left, right), width, top);
            top = p.bottom + GRID_GAP;
            placed.push(p);
        }
        paint(WIDTH, top - GRID_GAP + BORDER, |canvas| {
            title.draw(canvas, BORDER, BORDER)?;
            legend.draw(canvas, BORDER, BORDER + title.height())?;
            placed.iter().try_for_each(|p| p.draw(canvas, &used))
        })
    }
}

/// A grid with its place on the page.
struct Placed<'a> {
    grid: &'a TileGrid,
    title: Vec<String>,
    columns: Vec<Vec<String>>,
    /// The cells.
    rect: Rect,
    /// Where its labels end.
    bottom: f64,
}

impl<'a> Placed<'a> {
    fn new(grid: &'a TileGrid, (left, right): (f64, f64), width: f64, top: f64) -> Self {
        let title = text::wrap(&grid.title, right - left, SIZE, true, 2);
        let columns: Vec<Vec<String>> =
            grid.columns.iter().map(|c| text::wrap(c, width - 4.0, SIZE, false, 3)).collect();
        let top = top + title.len() as f64 * LINE + if title.is_empty() { 0.0 } else { 4.0 };
        let rect = Rect {
            left,
            top,
            right: left + width * grid.columns.len() as f64,
            bottom: top + ROW * grid.rows.len() as f64,
        };
        let lines = columns.iter().map(Vec::len).max().unwrap_or(0) + usize::from(!grid.column_label.is_empty());
        let bottom = rect.bottom + 4.0 + lines as f64 * LINE;
        Placed { grid, title, columns, rect, bottom }
    }

    /// What a tile says, with its row and column.
    fn said(&self, tile: &Tile) -> String {
        let grid = self.grid;
        let place = [(&grid.row_label, &grid.rows[tile.row]), (&grid.column_label, &grid.columns[tile.column])];
        let place = place.map(|(label, name)| format!("{label} {name}").trim().to_owned());
        let label = if tile.label.is_empty() { String::new() } else { format!(" ({})", tile.label) };
        format!("{}: {}{label}", place.join(", "), tile.category)
    }

    fn draw(&self, canvas: &Canvas, used: &[(String, Color)]) -> Result<()> {
        let (grid, r) = (self.grid, self.rect);
        let width = r.width() / grid.columns.len() as f64;
        for (k, line) in self.title.iter().enumerate() {
            let base = r.top - 4.0 - (self.title.len() - 1 - k) as f64 * LINE - 0.25 * SIZE;
            canvas.text(line, (r.left, base), Align::Left, Look { bold: true, ..Look::PLAIN })?;
        }
        let line = Stroke::solid(Color::GRAY.mix(Color(255, 255, 255), 0.75), 0.75);
        for k in 1..grid.rows.len() {
            let y = r.top + ROW * k as f64;
            canvas.line(&[(r.left, y), (r.right, y)], line)?;
        }
        for t in &grid.tiles {
            let color = used.iter().find(|c| c.0 == t.category).map_or(Color::GRAY, |c| c.1);
            let cell = Rect {
                left: r.left + width * t.column as f64 + 1.0,
                top: r.top + ROW * t.row as f64 + 1.0,
                right: r.left + width * (t.column + 1) as f64 - 1.0,
                bottom: r.top + ROW * (t.row + 1) as f64 - 1.0,
            };
            canvas.rect(cell, color)?;
            let (label, size) = fitted(&t.label, cell.width() - 6.0);
            let base = f64::midpoint(cell.top, cell.bottom) + 0.36 * size;
            let look = Look { size, ..Look::PLAIN };
            canvas.text(&label, (f64::midpoint(cell.left, cell.right), base), Align::Center, look)?;
            reading::value(canvas, cell, &self.said(t));
        }
        canvas.border(r, Stroke::solid(Color::INK, 1.0))?;
        for (k, name) in grid.rows.iter().enumerate() {
            let (name, size) = fitted(name, NAME_ROOM);
            let base = r.top + ROW * (k as f64 + 0.5) + 0.36 * size;
            canvas.text(&name, (r.left - GAP, base), Align::Right, Look { size, ..Look::PLAIN })?;
        }
        for (c, lines) in self.columns.iter().enumerate() {
            let center = r.left + width * (c as f64 + 0.5);
            for (k, name) in lines.iter().enumerate() {
                let base = r.bottom + 4.0 + (k as f64 + 0.8) * LINE;
                canvas.text(name, (center, base), Align::Center, Look::PLAIN)?;
            }
        }
        if !grid.column_label.is_empty() {
            let (label, size) = fitted(&grid.column_label, WIDTH - r.left - BORDER);
            let base = self.bottom - 0.2 * LINE;
            let at = (f64::midpoint(r.left, r.right), base);
            // A label that is wider than its narrow grid starts with it.
            let (at, align) = if text::width(&label, size, false) > r.width() {
                ((r.left, base), Align::Left)
            } else {
                (at, Align::Center)
            };
            canvas.text(&label, at, align, Look { size, ..Look::PLAIN })?;
        }
        if !grid.row_label.is_empty() {
            let (label, size) = fitted(&grid.row_label, r.height() + LINE);
            let at = (BORDER + 0.8 * SIZE, f64::midpoint(r.top, r.bottom));
            canvas.text(&label, at, Align::Center, Look { size, upright: true, ..Look::PLAIN })?;
        }
        Ok(())
    }
}

/// The text and the size in which it fits; cut where even the smallest size is too large.
fn fitted(label: &str, available: f64) -> (String, f64) {
    let wide = text::width(label, SIZE, false);
    if wide <= available {
        return (label.to_owned(), SIZE);
    }
    let size = (SIZE * available / wide).max(SMALLEST);
    let lines = text::wrap(&label.replace(' ', "\u{a0}"), available, size, false, 1);
    (lines.into_iter().next().unwrap_or_default(), size)
}
