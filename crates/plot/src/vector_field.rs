//! Arrows over two quantities.

use crate::color::Color;
use crate::color_map::ColorMap;
use crate::drawing::Drawing;
use crate::error::{PlotError, Result, check_finite, check_interval};
use crate::field::{ColorScale, Field, Labels, Mark};
use crate::legend::Sample;
use crate::setters::setters;
use crate::ticks::padded_range;

/// An arrow at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrow {
    /// Position of its tail on the horizontal axis.
    pub x: f64,
    /// Position of its tail on the vertical axis.
    pub y: f64,
    /// Component to the right.
    pub u: f64,
    /// Component upwards.
    pub v: f64,
    /// The third quantity, which gives its color.
    pub value: f64,
}

impl Arrow {
    /// The arrow `(u, v)` at `(x, y)`, colored by `value`; a NaN among `u`, `v`, `value` is a missing arrow.
    pub fn new((x, y): (f64, f64), (u, v): (f64, f64), value: f64) -> Self {
        Self { x, y, u, v, value }
    }

    fn is_missing(&self) -> bool {
        self.u.is_nan() || self.v.is_nan() || self.value.is_nan()
    }
}

/// A field of vectors over two quantities: their direction on the page is `(u, v)` itself, whatever the axes are, and a
/// reference arrow in the legend gives their length.
///
/// ```
/// use bracketry_plot::{Arrow, VectorField};
/// let arrows = [Arrow::new((0.0, 0.0), (0.1, 0.0), 0.3), Arrow::new((1.0, 0.0), (0.0, 0.05), -0.2)];
/// let drawing = VectorField::new("phase [rad]", "amplitude [m]", "mean velocity", "m/s")
///     .arrows(arrows)
///     .color_label("mean yaw rate [rad/s]")
///     .draw()?;
/// assert!(drawing.svg().contains("mean velocity 0.1 m/s"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct VectorField {
    labels: Labels,
    vector_name: String,
    unit: String,
    arrows: Vec<Arrow>,
    color_label: Option<String>,
    map: ColorMap,
    range: Option<(f64, f64)>,
    longest: Option<f64>,
    missing: String,
    marks: Vec<Mark>,
}

impl VectorField {
    /// An empty field; the labels of the axes name quantity and unit, `vector_name` and `unit` what the arrows are.
    pub fn new(
        x_label: impl Into<String>,
        y_label: impl Into<String>,
        vector_name: impl Into<String>,
        unit: impl Into<String>,
    ) -> Self {
        Self {
            labels: Labels { title: String::new(), x: x_label.into(), y: y_label.into() },
            vector_name: vector_name.into(),
            unit: unit.into(),
            arrows: Vec::new(),
            color_label: None,
            map: ColorMap::DivergingDark,
            range: None,
            longest: None,
            missing: "no value".to_owned(),
            marks: Vec::new(),
        }
    }

    setters! {
        /// Adds arrows.
        arrows(arrows: impl IntoIterator<Item = Arrow>) |it| it.arrows.extend(arrows);
        /// Colors the arrows by their third quantity and names it; without this all are of one color.
        color_label(label: impl Into<String>) |it| it.color_label = Some(label.into());
        /// Sets the colors; [`ColorMap::DivergingDark`] if not set.
        color_map(map: ColorMap) |it| it.map = map;
        /// Sets the range of the colors; values beyond have the color of its end, which the color bar says.
        range(low: f64, high: f64) |it| it.range = Some((low, high));
        /// Sets the vector whose arrow is as long as the distance between neighbors; by default the longest one.
        longest(length: f64) |it| it.longest = Some(length);
        /// Sets the title.
        title(title: impl Into<String>) |it| it.labels.title = title.into();
        /// Sets what a missing arrow means, for the legend.
        missing(meaning: impl Into<String>) |it| it.missing = meaning.into();
        /// Points out the place `(x, y)`.
        mark(name: impl Into<String>, x: f64, y: f64) |it| it.marks.push(Mark::new(name, x, y));
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without arrows; otherwise what is wrong with the data.
    pub fn draw(&self) -> Result<Drawing> {
        if self.arrows.is_empty() {
            return Err(PlotError::NoContent { missing: "arrow" });
        }
        let (known, missing): (Vec<&Arrow>, Vec<&Arrow>) = self.arrows.iter().partition(|a| !a.is_missing());
        for a in &known {
            check_finite(&self.vector_name, &[a.x, a.y, a.u, a.v, a.value])?;
        }
        for a in &missing {
            check_finite(&self.vector_name, &[a.x, a.y])?;
        }
        if let Some((low, high)) = self.range {
            check_interval("range of the colors", low, high)?;
        }
        check_finite("longest arrow", self.longest.as_slice())?;
        let values = || known.iter().map(|a| a.value);
        let scale = self.color_label.as_ref().map(|label| ColorScale::new(label, self.map, self.range, values()));

        let places = |of: fn(&Arrow) -> f64| {
            let mut sorted: Vec<f64> = self.arrows.iter().map(of).collect();
            sorted.sort_by(f64::total_cmp);
            sorted.dedup();
            sorted
        };
        let (xs, ys) = (places(|a| a.x), places(|a| a.y));
        let range =
            |sorted: &[f64]| padded_range(sorted.iter().copied(), 0.5 / sorted.len().clamp(2, 20) as f64 + 0.04);
        let mut field = Field {
            labels: &self.labels,
            x: range(&xs),
            y: range(&ys),
            scale: scale.as_ref(),
            entries: Vec::new(),
            marks: &self.marks,
            grid: true,
        };
        let frame = field.frame();
        let gap = (frame.width() / xs.len().clamp(4, 40) as f64).min(frame.height() / ys.len().clamp(4, 40) as f64);
        let longest = match self.longest {
            Some(set) if set > 0.0 => set,
            _ => known.iter().map(|a| a.u.hypot(a.v)).fold(0.0, f64::max),
        };
        let per_unit = if longest > 0.0 { gap / longest } else { 0.0 };
        if longest > 0.0 {
            let reference = round_down(longest);
            let name = format!("{} {} {}", self.vector_name, label(reference), self.unit);
            field.entries.push((Sample::Arrow(reference * per_unit), name));
        }
        if !missing.is_empty() {
            field.entries.push((Sample::Cross, self.missing.clone()));
        }
        field.draw(|canvas, axes| {
            for a in &missing {
                canvas.cross(axes.page((a.x, a.y)))?;
            }
            for a in &known {
                let color = scale.as_ref().map_or(Color::BLUE, |s| s.color(a.value));
                canvas.arrow(axes.page((a.x, a.y)), (a.u * per_unit, -a.v * per_unit), color)?;
            }
            Ok(())
        })
    }
}

/// The largest of 1, 2, 5 × 10ⁿ that is not greater.
fn round_down(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    // A trifle of rounding does not cost a step.
    [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|v| *v <= value * (1.0 + 1e-9)).unwrap_or(power)
}

/// 1, 2 or 5 × 10ⁿ in as few characters as possible.
fn label(value: f64) -> String {
    let plain = format!("{:.*}", (-value.log10().floor()).clamp(0.0, 300.0) as usize, value);
    let scientific = format!("{value:.0e}");
    if plain.len() <= 7 { plain } else { scientific }
}
