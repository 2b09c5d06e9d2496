//! A panel's content: lines, targets, bounds and shaded intervals.

use crate::axes::Axes;
use crate::canvas::{Canvas, Dash, Rect, Stroke};
use crate::color::Color;
use crate::decimate::{clip_to_strip, decimate, simplify};
use crate::error::{Result, check_finite, check_interval, check_lengths};
use crate::legend::{Marker, Sample};
use crate::reading::{self, Curve, unit_of};
use crate::role::Role;
use crate::setters::setters;
use crate::ticks::three_digits;

/// Width of the columns by which long lines are thinned: one pixel of the PNG.
pub(crate) const COLUMN: f64 = 0.5;
/// Distance in pixels by which a line may be off for having fewer points.
pub(crate) const TOLERANCE: f64 = 0.05;
const LINE_WIDTH: f64 = 1.75;
pub(crate) const TARGET_BAND: Color = Color(214, 238, 226);

/// What every point of a series is marked with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Markers {
    /// Nothing.
    None,
    /// A shape of the series' own.
    Own,
    /// Crosses: points that are shown but put aside.
    Crosses,
}

/// A named line: values over abscissas.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; an empty one leaves the line out of it.
    pub name: String,
    /// Abscissas (times).
    pub x: Vec<f64>,
    /// Values, one for each abscissa.
    pub y: Vec<f64>,
    /// Color; `None` takes the next one of [`Color::series`].
    pub color: Option<Color>,
    /// Dashes.
    pub dash: Dash,
    /// Whether each value holds until the next abscissa, as a sampled input does.
    pub step: bool,
    /// The markers of the points.
    pub markers: Markers,
    /// Whether the points are joined by a line.
    pub line: bool,
    /// What happens at the last point, which gets a cross; none if it just ends.
    pub end: Option<String>,
}

impl Series {
    /// A solid line through the points `(x[i], y[i])`.
    pub fn new(name: impl Into<String>, x: impl Into<Vec<f64>>, y: impl Into<Vec<f64>>) -> Self {
        Self {
            name: name.into(),
            x: x.into(),
            y: y.into(),
            color: None,
            dash: Dash::Solid,
            step: false,
            markers: Markers::None,
            line: true,
            end: None,
        }
    }

    setters! {
        /// Sets the color.
        color(color: Color) |it| it.color = Some(color);
        /// Sets the dashes.
        dash(dash: Dash) |it| it.dash = dash;
    }

    /// Sets color and dashes to those of a role.
    #[must_use]
    pub fn role(self, role: Role) -> Self {
        self.color(role.color()).dash(role.dash())
    }

    setters! {
        /// A cloud of crosses: points that are shown but put aside.
        crosses() |it| (it.markers, it.line) = (Markers::Crosses, false);
        /// Marks the last point with a cross, such as `tips` where a body tips and its line ends; the legend names it.
        end(what: impl Into<String>) |it| it.end = Some(what.into());
        /// Holds each value until the next abscissa.
        step() |it| it.step = true;
        /// Marks every point.
        markers() |it| it.markers = Markers::Own;
        /// Marks every point and draws no line: a cloud of points in any order.
        points() |it| (it.markers, it.line) = (Markers::Own, false);
    }

    /// Where the line leaves the range `(low, high)` for good, as a point on its end and whether that is the upper one; none if it ends
    /// inside.
    fn leaves(&self, (low, high): (f64, f64)) -> Option<((f64, f64), bool)> {
        let inside = |v: f64| (low..=high).contains(&v);
        let last = self.y.iter().rposition(|v| inside(*v)).filter(|_| self.line)?;
        let (x, y, beyond) = (self.x[last], self.y[last], *self.y.get(last + 1)?);
        let upwards = beyond > high;
        let end = if upwards { high } else { low };
        let next = self.x[last + 1];
        let at = if self.step { next } else { x + (next - x) * (end - y) / (beyond - y) };
        Some(((at, end), upwards))
    }

    fn check(&self) -> Result<()> {
        check_lengths(&self.name, self.x.len(), self.y.len())?;
        check_finite(&self.name, &self.x)?;
        check_finite(&self.name, &self.y)
    }

    fn stroke(&self, index: usize) -> Stroke {
        // Where the colors start over, solid lines become dashed, then dotted.
        let dash = match (self.dash, self.color) {
            (Dash::Solid, None) => Dash::ALL[index / Color::SERIES % Dash::ALL.len()],
            (dash, _) => dash,
        };
        Stroke { color: self.color.unwrap_or_else(|| Color::series(index)), width: LINE_WIDTH, dash }
    }

    fn marker(&self, index: usize) -> Option<Marker> {
        match self.markers {
            Markers::None => None,
            Markers::Own => Some(Marker::series(index)),
            Markers::Crosses => Some(Marker::Cross),
        }
    }
}

/// An interval of the horizontal axis that belongs to a category, such as a friction mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// Start.
    pub start: f64,
    /// End, not before the start.
    pub end: f64,
    /// Name of the category in the legend.
    pub category: String,
}

impl Interval {
    /// The interval from `start` to `end`, of category `category`.
    pub fn new(start: f64, end: f64, category: impl Into<String>) -> Self {
        let category = category.into();
        Self { start, end, category }
    }
}

/// A value marked across a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Name in the legend, which lists every name once.
    pub name: String,
    /// The value.
    pub value: f64,
}

impl Level {
    /// The level `value`, called `name` in the legend.
    pub fn new(name: impl Into<String>, value: f64) -> Self {
        let name = name.into();
        Self { name, value }
    }
}

/// One plot: lines over a common horizontal axis, with targets, bounds and shaded intervals.
#[derive(Debug, Clone)]
pub struct Panel {
    /// Label of the vertical axis, with its unit in brackets at the end.
    pub label: String,
    /// The lines.
    pub series: Vec<Series>,
    /// Values to be reached, drawn dashed.
    pub targets: Vec<Level>,
    /// Values not to be crossed, drawn dotted.
    pub bounds: Vec<Level>,
    /// Tolerance around a target, `(low, high)`, shaded.
    pub target_band: Option<(f64, f64)>,
    /// Shaded intervals of this panel alone.
    pub intervals: Vec<Interval>,
    /// Range of the vertical axis; `None` fits it to the content.
    pub limits: Option<(f64, f64)>,
    /// Differences below this are rounding: the vertical axis takes them for none.
    pub rounding: f64,
    /// Height in figure pixels; `None` lets the figure choose.
    pub height: Option<f64>,
}

impl Panel {
    /// An empty panel; `label` names the quantity and its unit, such as `θ̇ [rad/s]`.
    pub fn new(label: impl Into<String>) -> Self {
        Self {
            label: label.into(),
            series: Vec::new(),
            targets: Vec::new(),
            bounds: Vec::new(),
            target_band: None,
            intervals: Vec::new(),
            limits: None,
            rounding: 0.0,
            height: None,
        }
    }

    setters! {
        /// Adds a line.
        series(series: Series) |it| it.series.push(series);
    }

    /// Adds a dashed line, `target` in the legend, at a value to be reached.
    #[must_use]
    pub fn target(self, value: f64) -> Self {
        self.named_target("target", value)
    }

    setters! {
        /// Adds a dashed line with a name of its own at a value to be reached.
        named_target(name: impl Into<String>, value: f64) |it| it.targets.push(Level::new(name, value));
    }

    /// Adds a dotted line, `bound` in the legend, at a value not to be crossed.
    #[must_use]
    pub fn bound(self, value: f64) -> Self {
        self.named_bound("bound", value)
    }

    setters! {
        /// Adds a dotted line with a name of its own at a value not to be crossed.
        named_bound(name: impl Into<String>, value: f64) |it| it.bounds.push(Level::new(name, value));
        /// Shades the values from `low` to `high` as good enough.
        target_band(low: f64, high: f64) |it| it.target_band = Some((low, high));
        /// Adds a shaded interval to this panel.
        interval(interval: Interval) |it| it.intervals.push(interval);
        /// Sets the range of the vertical axis; what lies outside is clipped.
        limits(low: f64, high: f64) |it| it.limits = Some((low, high));
        /// Sets the size below which differences are rounding and get no axis of their own.
        rounding(size: f64) |it| it.rounding = size;
        /// Sets the height in figure pixels (at least 60, at most 2000).
        height(pixels: f64) |it| it.height = Some(pixels);
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.series.iter().try_for_each(Series::check)?;
        for level in self.targets.iter().chain(&self.bounds) {
            check_finite(&format!("{} of {}", level.name, self.label), &[level.value])?;
        }
        check_finite(&format!("rounding of {}", self.label), &[self.rounding])?;
        check_finite(&format!("height of {}", self.label), self.height.as_slice())?;
        if let Some((low, high)) = self.target_band {
            check_interval(&format!("target band of {}", self.label), low, high)?;
        }
        if let Some((low, high)) = self.limits {
            check_interval(&format!("limits of {}", self.label), low, high)?;
        }
        self.intervals.iter().try_for_each(|i| check_interval(&i.category, i.start, i.end))
    }

    /// All values that the vertical axis should show.
    pub(crate) fn values(&self) -> impl Iterator<Item = f64> {
        let lines = self.series.iter().flat_map(|s| s.y.iter().copied());
        let levels = self.targets.iter().chain(&self.bounds).map(|l| l.value);
        let band = self.target_band.into_iter().flat_map(|(low, high)| [low, high]);
        let rounding = self.rounding;
        let rounded = move |v: f64| if rounding > 0.0 { (v / rounding).round() * rounding } else { v };
        lines.chain(levels).chain(band).map(rounded)
    }

    /// All abscissas that the horizontal axis should show.
    pub(crate) fn abscissas(&self) -> impl Iterator<Item = f64> {
        let lines = self.series.iter().flat_map(|s| s.x.iter().copied());
        lines.chain(self.intervals.iter().flat_map(|i| [i.start, i.end]))
    }

    /// Legend of the lines and of the marks on them.
    pub(crate) fn entries(&self) -> Vec<(Sample, String)> {
        let entry = |(k, s): (usize, &Series)| {
            let sample = match s.marker(k) {
                Some(marker) if !s.line => Sample::Point(marker, s.stroke(k).color),
                marker => Sample::Line(s.stroke(k), marker),
            };
            (sample, s.name.clone())
        };
        self.series.iter().enumerate().map(entry).chain(self.marks()).collect()
    }

    /// Names of the marks on the lines with their samples.
    fn marks(&self) -> Vec<(Sample, String)> {
        let ends = self.series.iter().filter_map(|s| s.end.clone());
        let mut marks: Vec<_> = ends.map(|what| (Sample::Mark(Marker::Cross), what)).collect();
        marks.dedup();
        if let Some(limits) = self.limits {
            for series in self.series.iter().filter(|s| s.leaves(limits).is_some()) {
                let to = series
                    .y
                    .last()
                    .map_or(String::new(), |v| format!(" (ends at {}{})", three_digits(*v), unit_of(&self.label)));
                marks.push((Sample::Beyond, format!("off scale{to}")));
            }
        }
        marks
    }

    /// Draws the lines, targets and bounds of panel `number` of a figure; `spread` is the distance in pixels by which the lines are set
    /// beside each other.
    pub(crate) fn draw_lines(&self, canvas: &Canvas, axes: &Axes, spread: f64, number: usize) -> Result<()> {
        let r = axes.rect;
        for (levels, stroke) in [(&self.bounds, bound_stroke()), (&self.targets, target_stroke())] {
            for y in levels.iter().map(|l| axes.page_y(l.value)) {
                if (r.top..=r.bottom).contains(&y) {
                    canvas.line(&[(r.left, y), (r.right, y)], stroke)?;
                }
            }
        }
        let middle = (self.series.len().max(1) - 1) as f64 / 2.0;
        for (k, series) in self.series.iter().enumerate() {
            let shift = (k as f64 - middle) * spread;
            let place = |x: f64, y: f64| (axes.page_x(x) + shift, axes.page_y(y));
            let data = || series.x.iter().zip(&series.y).map(|(x, y)| (*x, *y));
            let mut points = Vec::with_capacity(series.x.len() * (1 + usize::from(series.step)));
            for (x, y) in data() {
                if let (true, Some((_, held))) = (series.step, points.last()) {
                    points.push((place(x, y).0, *held));
                }
                points.push(place(x, y));
            }
            let stroke = series.stroke(k);
            let curve = Curve { panel: number, index: k, name: &series.name, shift };
            let parts =
                if series.line { clip_to_strip(&decimate(&points, COLUMN), r.top, r.bottom) } else { Vec::new() };
            for part in parts {
                match part.as_slice() {
                    [only] => canvas.disk(*only, 3.0, stroke.color)?,
                    line => canvas.curve(&simplify(line, TOLERANCE), stroke, curve.attributes())?,
                }
            }
            if let Some(marker) = series.marker(k) {
                let inside = data().map(|(x, y)| place(x, y)).filter(|p| (r.top..=r.bottom).contains(&p.1));
                let inside: Vec<_> = inside.collect();
                // Points of a line may be thinned by columns; those of a cloud have no order.
                let marks = if series.line { decimate(&inside, COLUMN) } else { inside };
                if !series.line {
                    reading::points(canvas, &curve, &marks);
                }
                marks.into_iter().try_for_each(|p| marker.draw(canvas, p, stroke.color))?;
            }
            if let Some(((x, y), upwards)) = self.limits.and_then(|limits| series.leaves(limits)) {
                canvas.beyond(place(x, y), upwards, stroke.color)?;
            }
        }
        // Over all lines.
        for (k, series) in self.series.iter().enumerate().filter(|(_, s)| s.end.is_some()) {
            if let (Some(x), Some(y)) = (series.x.last(), series.y.last()) {
                let at = (axes.page_x(*x) + (k as f64 - middle) * spread, axes.page_y(*y));
                if (r.top..=r.bottom).contains(&at.1) {
                    Marker::Cross.draw_rimmed(canvas, at)?;
                }
            }
        }
        Ok(())
    }

    /// Shades the target band.
    pub(crate) fn draw_target_band(&self, canvas: &Canvas, axes: &Axes) -> Result<()> {
        let Some((low, high)) = self.target_band else {
            return Ok(());
        };
        let r = axes.rect;
        let band = Rect {
            top: axes.page_y(high).clamp(r.top, r.bottom),
            bottom: axes.page_y(low).clamp(r.top, r.bottom),
            ..r
        };
        canvas.rect(band, TARGET_BAND)?;
        let edge = Stroke::solid(Color::GREEN.mix(TARGET_BAND, 0.5), 0.75);
        canvas.line(&[(r.left, band.top), (r.right, band.top)], edge)?;
        canvas.line(&[(r.left, band.bottom), (r.right, band.bottom)], edge)
    }
}

pub(crate) fn target_stroke() -> Stroke {
    Stroke { color: Color::INK, width: 1.25, dash: Dash::Dashed }
}

pub(crate) fn bound_stroke() -> Stroke {
    Stroke { color: Color::GRAY, width: 1.5, dash: Dash::Dotted }
}
