//! Figures of panels: stacked over a common time axis, or one alone.

use crate::axes::{Axes, TICK_ROOM, Title, horizontal_scale, tick_width};
use crate::canvas::{Canvas, Rect, paint};
use crate::color::Color;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result, check_interval};
use crate::legend::{Legend, Sample};
use crate::panel::{Interval, Panel, TARGET_BAND, bound_stroke, target_stroke};
use crate::reading;
use crate::setters::setters;
use crate::text::{self, LEADING, SIZE};
use crate::ticks::{Scale, padded_range};

/// Width of every figure in figure pixels.
pub(crate) const WIDTH: f64 = 800.0;
/// White border of every figure.
pub(crate) const BORDER: f64 = 14.0;
/// Room at the right for half of the last tick label.
pub(crate) const RIGHT: f64 = 30.0;
const PANEL_GAP: f64 = 16.0;
/// Distance of a legend from the frame below it.
pub(crate) const LEGEND_GAP: f64 = 3.0;
/// Bands that reach less than this beyond the last one drawn are left out.
const BAND_STEP: f64 = 0.25;

/// Panels stacked over one time axis.
///
/// ```
/// use bracketry_plot::{Interval, Panel, Series, TimeSeries};
/// let t = vec![0.0, 0.5, 1.0];
/// let drawing = TimeSeries::new()
///     .title("Approach")
///     .panel(Panel::new("x [m]").series(Series::new("x", t.clone(), vec![0.48, 0.5, 0.54])).target(0.54))
///     .panel(Panel::new("Ẍ [m/s²]").series(Series::new("Ẍ", t, vec![1.0, -1.0, 0.0]).step()))
///     .interval(Interval::new(0.0, 0.4, "sticks"))
///     .draw()?;
/// assert!(drawing.svg().contains("Ẍ [m/s²]"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct TimeSeries {
    /// Title; empty for none.
    pub title: String,
    /// Label of the time axis.
    pub time_label: String,
    /// The panels, from top to bottom.
    pub panels: Vec<Panel>,
    /// Shaded intervals of all panels.
    pub intervals: Vec<Interval>,
    /// Colors of categories; others take the next one of [`Color::band`].
    pub category_colors: Vec<(String, Color)>,
}

impl Default for TimeSeries {
    fn default() -> Self {
        Self::new()
    }
}

impl TimeSeries {
    /// A figure without panels whose horizontal axis is `time [s]`.
    pub fn new() -> Self {
        Self {
            title: String::new(),
            time_label: "time [s]".to_owned(),
            panels: Vec::new(),
            intervals: Vec::new(),
            category_colors: Vec::new(),
        }
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
        /// Sets the label of the horizontal axis.
        time_label(label: impl Into<String>) |it| it.time_label = label.into();
        /// Adds a panel below the others.
        panel(panel: Panel) |it| it.panels.push(panel);
        /// Shades an interval in all panels.
        interval(interval: Interval) |it| it.intervals.push(interval);
        /// Sets the color of a category of intervals.
        category_color(category: impl Into<String>, color: Color) |it|
            it.category_colors.push((category.into(), color));
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without panels; otherwise what is wrong with the data.
    pub fn draw(&self) -> Result<Drawing> {
        self.intervals.iter().try_for_each(|i| check_interval(&i.category, i.start, i.end))?;
        let layout = Layout {
            title: &self.title,
            x_label: &self.time_label,
            x_ticks: &[],
            x_margin: 0.0,
            integer: false,
            spread: 0.0,
            height: 120.0,
            panels: &self.panels,
            intervals: &self.intervals,
            category_colors: &self.category_colors,
        };
        layout.draw()
    }
}

/// One panel over any quantity: a line or marker chart.
#[derive(Debug, Clone)]
pub struct XyChart {
    /// Title; empty for none.
    pub title: String,
    /// Label of the horizontal axis.
    pub x_label: String,
    /// The content.
    pub panel: Panel,
    /// Whether both axes count things, see [`Self::integer`].
    pub integer: bool,
    /// Whether the lines stand a few pixels beside each other, so that equal values do not hide one another.
    pub beside: bool,
    /// Places on the horizontal axis that are labeled in place of round numbers; none for those.
    pub x_ticks: Vec<(f64, String)>,
}

impl XyChart {
    /// A chart of `panel` over the quantity named `x_label`.
    pub fn new(x_label: impl Into<String>, panel: Panel) -> Self {
        Self {
            title: String::new(),
            x_label: x_label.into(),
            panel,
            integer: false,
            beside: false,
            x_ticks: Vec::new(),
        }
    }

    /// Labels places on the horizontal axis, such as 100 at 2 where it holds decimal logarithms.
    #[must_use]
    pub fn x_ticks<S: Into<String>>(mut self, ticks: impl IntoIterator<Item = (f64, S)>) -> Self {
        self.x_ticks = ticks.into_iter().map(|(place, label)| (place, label.into())).collect();
        self
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
        /// Sets the lines a few pixels beside each other, so that equal values do not hide one another.
        beside() |it| it.beside = true;
    }

    /// Both axes count things, such as dimension over bracket length: ticks only at whole numbers, and [`Self::beside`].
    #[must_use]
    pub fn integer(mut self) -> Self {
        self.integer = true;
        self.beside()
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// What is wrong with the data.
    pub fn draw(&self) -> Result<Drawing> {
        let layout = Layout {
            title: &self.title,
            x_label: &self.x_label,
            x_ticks: &self.x_ticks,
            x_margin: 0.04,
            integer: self.integer,
            spread: if self.beside { 6.0 } else { 0.0 },
            height: 340.0,
            panels: std::slice::from_ref(&self.panel),
            intervals: &[],
            category_colors: &[],
        };
        layout.draw()
    }
}

/// What both figures have in common.
struct Layout<'a> {
    title: &'a str,
    x_label: &'a str,
    x_ticks: &'a [(f64, String)],
    x_margin: f64,
    integer: bool,
    spread: f64,
    height: f64,
    panels: &'a [Panel],
    intervals: &'a [Interval],
    category_colors: &'a [(String, Color)],
}

impl Layout<'_> {
    fn draw(&self) -> Result<Drawing> {
        if self.panels.is_empty() {
            return Err(PlotError::NoContent { missing: "panel" });
        }
        self.panels.iter().try_for_each(Panel::check)?;

        let heights: Vec<f64> =
            self.panels.iter().map(|p| p.height.unwrap_or(self.height).clamp(60.0, 2000.0)).collect();
        let scales: Vec<Scale> = self.panels.iter().zip(&heights).map(|(p, h)| self.y_scale(p, *h)).collect();
        let tick_room = scales.iter().map(tick_width).fold(0.0, f64::max);
        let labels: Vec<Vec<String>> = {
            let whole = self.panels.iter().zip(&scales).map(|(p, scale)| scale.label(&p.label));
            whole.zip(&heights).map(|(label, h)| text::wrap_label(&label, h + PANEL_GAP)).collect()
        };
        let label_lines = labels.iter().map(Vec::len).max().unwrap_or(0);
        let label_gap = tick_room + 8.0;
        let left = BORDER + label_gap + label_lines as f64 * SIZE * LEADING;
        let right = WIDTH - RIGHT;
        let x = self.x_scale(right - left);

        let colors = self.categories();
        let title = Title::figure(self.title, right - BORDER);
        // With one panel all names go into one legend.
        let alone = self.panels.len() == 1;
        let mut own: Vec<_> = self.panels.iter().map(Panel::entries).collect();
        let mut shared = taken_out_of(&mut own);
        shared.append(&mut self.common_entries(&colors));
        if let ([only], true) = (own.as_mut_slice(), alone) {
            only.append(&mut shared);
        }
        let common = Legend::new(shared, right - left);
        let legends: Vec<Legend> = own.into_iter().map(|e| Legend::new(e, right - left)).collect();
        let x_label = text::wrap(&x.label(self.x_label), right - left, SIZE, false, 3);

        let mut top = BORDER + title.height();
        let common_top = top;
        top += common.height() + if common.height() > 0.0 { 6.0 } else { 0.0 };
        let mut tops = Vec::new();
        for (legend, height) in legends.iter().zip(&heights) {
            let above = match legend.height() {
                0.0 => 0.0,
                height => height + LEGEND_GAP,
            };
            tops.push(top + above);
            top += above + height + PANEL_GAP;
        }
        let below = TICK_ROOM + x_label.len().max(1) as f64 * SIZE * LEADING;
        let height = top - PANEL_GAP + below + BORDER;

        paint(WIDTH, height, |canvas| {
            title.draw(canvas, BORDER, BORDER)?;
            common.draw(canvas, left, common_top)?;
            for (k, panel) in self.panels.iter().enumerate() {
                let rect = Rect { left, top: tops[k], right, bottom: tops[k] + heights[k] };
                let axes = Axes { rect, x: x.clone(), y: scales[k].clone() };
                legends[k].draw(canvas, left, tops[k] - legends[k].height() - LEGEND_GAP)?;
                for intervals in [self.intervals, &panel.intervals] {
                    shade(canvas, &axes, intervals, &colors)?;
                }
                panel.draw_target_band(canvas, &axes)?;
                axes.grid_x(canvas)?;
                axes.grid_y(canvas)?;
                panel.draw_lines(canvas, &axes, self.spread, k)?;
                reading::panel(canvas, k, &axes, (self.x_label, &panel.label));
                axes.frame(canvas)?;
                axes.label_left(canvas, &labels[k], label_gap)?;
                if k + 1 == self.panels.len() {
                    axes.label_below(canvas, &x_label)?;
                }
            }
            Ok(())
        })
    }

    fn y_scale(&self, panel: &Panel, height: f64) -> Scale {
        let (low, high) = match panel.limits {
            Some((low, high)) => padded_range([low, high], 0.0),
            None => padded_range(panel.values(), 0.07),
        };
        Scale::new(low, high, height / 45.0 + 1.0, self.integer)
    }

    fn x_scale(&self, width: f64) -> Scale {
        let own = self.panels.iter().flat_map(Panel::abscissas);
        let common = self.intervals.iter().flat_map(|i| [i.start, i.end]);
        let (low, high) = padded_range(own.chain(common), self.x_margin);
        let scale = horizontal_scale((low, high), width, 85.0, self.integer);
        if self.x_ticks.is_empty() {
            return scale;
        }
        let inside = |tick: &&(f64, String)| (low..=high).contains(&tick.0);
        Scale { ticks: self.x_ticks.iter().filter(inside).cloned().collect(), factor: String::new(), ..scale }
    }

    /// The categories in order of appearance, with their colors.
    fn categories(&self) -> Vec<(&str, Color)> {
        let mut found: Vec<(&str, Color)> = Vec::new();
        let own = self.panels.iter().flat_map(|p| &p.intervals);
        for interval in self.intervals.iter().chain(own) {
            if found.iter().all(|(name, _)| *name != interval.category) {
                let set = self.category_colors.iter().find(|(name, _)| *name == interval.category);
                let color = set.map_or_else(|| Color::band(found.len()), |(_, c)| *c);
                found.push((&interval.category, color));
            }
        }
        found
    }

    /// Legend of what several panels share: targets, bounds, categories.
    fn common_entries(&self, colors: &[(&str, Color)]) -> Vec<(Sample, String)> {
        let mut entries: Vec<(Sample, String)> = Vec::new();
        let mut add = |sample: Sample, name: &str| {
            if entries.iter().all(|(_, known)| known != name) {
                entries.push((sample, name.to_owned()));
            }
        };
        for panel in self.panels {
            for level in &panel.targets {
                add(Sample::Line(target_stroke(), None), &level.name);
            }
            if panel.target_band.is_some() {
                add(Sample::Patch(TARGET_BAND), "target band");
            }
        }
        for level in self.panels.iter().flat_map(|p| &p.bounds) {
            add(Sample::Line(bound_stroke(), None), &level.name);
        }
        let patch = |(name, color): &(&str, Color)| (Sample::Patch(*color), (*name).to_owned());
        entries.extend(colors.iter().map(patch));
        entries
    }
}

/// Takes what looks alike in several panels out of their legends, for one over all of them; what would look like something else in
/// another panel stays.
fn taken_out_of(own: &mut [Vec<(Sample, String)>]) -> Vec<(Sample, String)> {
    let all: Vec<&(Sample, String)> = own.iter().flatten().filter(|entry| !entry.1.is_empty()).collect();
    let mut shared: Vec<(Sample, String)> = Vec::new();
    for entry in &all {
        let several = all.iter().filter(|other| *other == entry).count() > 1;
        let alone_of_its_look = all.iter().all(|other| (other.0 == entry.0) == (other.1 == entry.1));
        if several && alone_of_its_look && !shared.contains(entry) {
            shared.push((*entry).clone());
        }
    }
    for entries in own {
        entries.retain(|entry| !shared.contains(entry));
    }
    shared
}

fn shade(canvas: &Canvas, axes: &Axes, intervals: &[Interval], colors: &[(&str, Color)]) -> Result<()> {
    let r = axes.rect;
    let mut drawn: Option<Rect> = None;
    for interval in intervals {
        let band = Rect {
            left: axes.page_x(interval.start),
            // A trifle wider, so that no white shines through between two neighbors.
            right: (axes.page_x(interval.end) + 0.3).min(r.right),
            ..r
        };
        if drawn.is_some_and(|d| band.left >= d.left && band.right < d.right + BAND_STEP) {
            continue;
        }
        if let Some((_, color)) = colors.iter().find(|(name, _)| *name == interval.category) {
            canvas.rect(band, *color)?;
            drawn = Some(band);
        }
    }
    Ok(())
}
