//! An object on a shaken and tilted plate, in time.

use std::path::Path;

use crate::axes::{Axes, TICK_ROOM, Title, horizontal_scale, tick_width};
use crate::canvas::{Align, Canvas, Dash, Look, Rect, Stroke, paint};
use crate::color::Color;
use crate::decimate::{decimate, simplify};
use crate::drawing::{Drawing, write};
use crate::error::{PlotError, Result, check_finite, check_increasing};
use crate::gif_images::GifImages;
use crate::legend::{Legend, Marker, Sample};
use crate::motion::{Outline, Pose};
use crate::panel::{COLUMN, TOLERANCE};
use crate::role::Role;
use crate::setters::setters;
use crate::stack::{BORDER, RIGHT, WIDTH};
use crate::text::{self, LEADING, SIZE};
use crate::ticks::{Scale, format_number, padded_range};

const LINE: f64 = SIZE * LEADING;
/// Share of the width that the view from above has.
const PLAN_SHARE: f64 = 0.62;
/// Largest height of the views.
const TALLEST: f64 = 400.0;
/// Smallest thickness of the object in the view from the side, in pixels.
const THINNEST: f64 = 4.0;
/// Hundredths of a second for which the last image stays, so that the end can be seen.
const HOLD: u16 = 150;
/// Snapshots from which the colors of the GIF are taken.
const SAMPLE: usize = 8;

const PLATE: Color = Color(240, 240, 240);

/// The object and the plate at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Snapshot {
    /// Time in seconds.
    pub time: f64,
    /// Displacement of the plate along x, in meters.
    pub displacement: f64,
    /// Tilt of the plate about its x axis in radians; positive raises +y.
    pub tilt: f64,
    /// Position of the object's center on the plate in meters, and its yaw.
    pub pose: Pose,
    /// Gap between plate and object in meters; 0 in contact.
    pub gap: f64,
    /// Tilt of the object against the plate about the x axis, in radians.
    pub lean: f64,
    /// Number of the category, such as sticking or sliding, that gives the object its color.
    pub category: usize,
}

/// An object on a plate in time: beside each other the view along the plate's normal, in which the plate is shaken, and
/// the view along the axis about which it tilts.
///
/// ```
/// use bracketry_plot::{Animation, Color, Outline, Pose, Snapshot};
/// let snapshots = (0..5).map(|k| Snapshot {
///     time: 0.05 * f64::from(k),
///     displacement: 0.01 * f64::from(k),
///     tilt: 0.1,
///     pose: Pose::new(0.3, 0.0, 0.1 * f64::from(k)),
///     gap: 0.0,
///     lean: 0.0,
///     category: 0,
/// });
/// let animation = Animation::new(Outline::Ellipse { a: 0.15, b: 0.1 }, 0.005)
///     .category("slides", Color::BLUE)
///     .snapshots(snapshots);
/// assert!(animation.image(4)?.svg().contains("t = 0.20 s"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Animation {
    title: String,
    outline: Outline,
    thickness: f64,
    categories: Vec<(String, Color)>,
    snapshots: Vec<Snapshot>,
    target: Option<Pose>,
    /// Time and place.
    path: Vec<(f64, f64, f64)>,
    trail: Color,
    end: Option<String>,
}

/// Ranges and scales that all images share.
struct Layout {
    /// The part of the plate that is shown, in its own frame: least and greatest x, then y.
    plate: ((f64, f64), (f64, f64)),
    plan: Axes,
    side: Axes,
    legend: Legend,
    title: Title,
    height: f64,
}

impl Animation {
    /// An animation without snapshots of an object with this outline and thickness (m).
    pub fn new(outline: Outline, thickness: f64) -> Self {
        Self {
            title: String::new(),
            outline,
            thickness,
            categories: Vec::new(),
            snapshots: Vec::new(),
            target: None,
            path: Vec::new(),
            trail: Color::BLUE,
            end: None,
        }
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
        /// Adds a category with its color; they are numbered from 0. The legend shows those that occur.
        category(name: impl Into<String>, color: Color) |it| it.categories.push((name.into(), color));
        /// Adds snapshots; the time between two of them is that between the first two.
        snapshots(snapshots: impl IntoIterator<Item = Snapshot>) |it| it.snapshots.extend(snapshots);
        /// Sets where the object's center was, as `(t, x, y)` in order of time, for a path that is finer than the snapshots.
        path(places: impl IntoIterator<Item = (f64, f64, f64)>) |it| it.path = places.into_iter().collect();
        /// Draws the path in the color of a role.
        role(role: Role) |it| it.trail = role.color();
        /// Sets what happens at the end, such as `the object tips`: it stands beside the last time, and the object's place gets a cross.
        end(what: impl Into<String>) |it| it.end = Some(what.into());
        /// Sets the pose to be reached.
        target(pose: Pose) |it| it.target = Some(pose);
    }

    /// The image of snapshot `index`; one beyond the last is the last.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without snapshots, [`PlotError::UnknownCategory`]; otherwise what is wrong with the data.
    pub fn image(&self, index: usize) -> Result<Drawing> {
        self.check()?;
        self.draw(&self.layout(), index.min(self.snapshots.len() - 1))
    }

    /// The GIF in real time (to a hundredth of a second per image), over and over; the last image stays for a while.
    ///
    /// # Errors
    /// As [`Self::image`].
    pub fn gif(&self) -> Result<Vec<u8>> {
        self.check()?;
        let layout = self.layout();
        let count = self.snapshots.len();
        let step = match self.snapshots.as_slice() {
            [first, second, ..] => second.time - first.time,
            _ => 1.0,
        };
        let delay = (100.0 * step).round().clamp(2.0, 1000.0) as u16;
        let sampled = (0..SAMPLE.min(count)).map(|k| k * (count - 1) / SAMPLE.min(count).max(2).saturating_sub(1));
        let sample = sampled.map(|k| self.draw(&layout, k)?.pixmap(1)).collect::<Result<Vec<_>>>()?;
        let mut images = GifImages::new(&sample)?;
        drop(sample);
        for k in 0..count {
            let delay = if k + 1 == count { delay.saturating_add(HOLD) } else { delay };
            images.push(&self.draw(&layout, k)?.pixmap(1)?, delay)?;
        }
        images.finish()
    }

    /// The last image as a PNG of the size of the GIF, to stand for it.
    ///
    /// # Errors
    /// As [`Self::image`].
    pub fn still(&self) -> Result<Vec<u8>> {
        self.image(self.snapshots.len().saturating_sub(1))?.png_of_scale(1)
    }

    /// Writes the GIF, creating the folder if it is missing.
    ///
    /// # Errors
    /// [`PlotError::Write`] with the path that could not be written, or as [`Self::gif`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        write(path.as_ref(), &self.gif()?)
    }

    fn check(&self) -> Result<()> {
        if self.snapshots.is_empty() {
            return Err(PlotError::NoContent { missing: "snapshot" });
        }
        let times: Vec<f64> = self.snapshots.iter().map(|s| s.time).collect();
        check_increasing("time of the snapshots", &times)?;
        check_finite("thickness", &[self.thickness])?;
        let (u, v): (Vec<f64>, Vec<f64>) = self.outline.points().into_iter().unzip();
        check_finite("outline", &u)?;
        check_finite("outline", &v)?;
        for s in &self.snapshots {
            let pose = s.pose;
            check_finite("a snapshot", &[s.displacement, s.tilt, pose.x, pose.y, pose.phi, s.gap, s.lean])?;
            if s.category >= self.categories.len() {
                return Err(PlotError::UnknownCategory { category: s.category, known: self.categories.len() });
            }
        }
        self.path.iter().try_for_each(|(t, x, y)| check_finite("path", &[*t, *x, *y]))?;
        self.target.map_or(Ok(()), |p| check_finite("target", &[p.x, p.y, p.phi]))
    }

    fn layout(&self) -> Layout {
        let shape = self.outline.points();
        let poses = self.snapshots.iter().map(|s| s.pose).chain(self.target);
        let corners = poses.flat_map(|p| shape.iter().map(move |q| p.place(*q)).chain([(p.x, p.y)]));
        let (x, y): (Vec<f64>, Vec<f64>) = corners.unzip();
        let x = padded_range(x, 0.08);
        // The axis of rotation belongs to what is seen.
        let y = padded_range(y.into_iter().chain([0.0]), 0.08);
        let displacements = || self.snapshots.iter().map(|s| s.displacement);
        let (least, most) = displacements().fold((0.0f64, 0.0f64), |(l, h), d| (l.min(d), h.max(d)));
        let seen_x = padded_range([x.0 + least, x.1 + most], 0.03);
        let seen_y = padded_range([y.0, y.1], 0.03);
        let reach = y.0.abs().max(y.1.abs());
        let steepest = self.snapshots.iter().map(|s| s.tilt.abs()).fold(0.0, f64::max);
        let highest = self.snapshots.iter().map(|s| s.gap).fold(0.0, f64::max) + self.thickness;
        let rise = (reach * steepest.sin().abs() + highest).max(0.25 * reach);

        let label_room = |low: f64, high: f64| tick_width(&Scale::new(low, high, 6.0, false)) + 6.0 + LINE;
        let plan_left = BORDER + label_room(seen_y.0 - 1.0, seen_y.1 + 1.0);
        let plan_right = PLAN_SHARE * WIDTH - 8.0;
        let side_left = PLAN_SHARE * WIDTH + label_room(-rise - 1.0, rise + 1.0);
        let side_right = WIDTH - RIGHT;
        let plan_width = plan_right - plan_left;
        let per_unit = (plan_width / (seen_x.1 - seen_x.0)).min(TALLEST / (seen_y.1 - seen_y.0));
        let tall = (per_unit * (seen_y.1 - seen_y.0)).clamp(200.0, TALLEST);
        let side_width = side_right - side_left;
        let side_unit = (side_width / (2.1 * reach)).min(tall / (2.1 * rise));

        let title = Title::figure(&self.title, WIDTH - BORDER - RIGHT);
        let occurring =
            self.categories.iter().enumerate().filter(|(k, _)| self.snapshots.iter().any(|s| s.category == *k));
        let mut entries: Vec<(Sample, String)> =
            occurring.map(|(_, (name, color))| (Sample::Patch(fill(*color)), name.clone())).collect();
        entries.push((Sample::Line(Stroke::solid(self.trail, 1.75), None), "path on the plate".to_owned()));
        entries.push((Sample::Heading(Color::INK), "heading".to_owned()));
        if self.target.is_some() {
            entries.push((Sample::Line(target_stroke(), None), "target".to_owned()));
        }
        let legend = Legend::new(entries, WIDTH - BORDER - RIGHT);
        // Under title and legend a line with the time, above each view a line with its numbers.
        let top = BORDER + title.height() + legend.height() + 2.0 * LINE + 6.0;
        let height = top + tall + TICK_ROOM + LINE + BORDER;
        let axes = |(left, width): (f64, f64), unit: f64, (x, y): (f64, f64)| {
            let around = |center: f64, pixels: f64| (center - pixels / unit / 2.0, center + pixels / unit / 2.0);
            let (low, high) = around(y, tall);
            Axes {
                rect: Rect { left, top, right: left + width, bottom: top + tall },
                x: horizontal_scale(around(x, width), width, 70.0, false),
                y: Scale::new(low, high, tall / 55.0, false),
            }
        };
        let center = |(low, high): (f64, f64)| f64::midpoint(low, high);
        let plan = axes((plan_left, plan_width), per_unit, (center(seen_x), center(seen_y)));
        let side = axes((side_left, side_width), side_unit, (0.0, 0.0));
        Layout { plate: (x, y), plan, side, legend, title, height }
    }

    fn draw(&self, layout: &Layout, index: usize) -> Result<Drawing> {
        let now = &self.snapshots[index];
        paint(WIDTH, layout.height, |canvas| {
            layout.title.draw(canvas, BORDER, BORDER)?;
            let legend_top = BORDER + layout.title.height();
            layout.legend.draw(canvas, BORDER, legend_top)?;
            let bold = Look { bold: true, ..Look::PLAIN };
            let base = legend_top + layout.legend.height() + LINE;
            let end = self.end_at(index).map_or(String::new(), |what| format!(": {what}"));
            canvas.text(&format!("t = {:.2} s{end}", now.time), (layout.plan.rect.left, base), Align::Left, bold)?;
            let over = layout.plan.rect.top - 6.0;
            let plan = format!(
                "seen along the normal:  X = {} mm,  φ = {}°",
                format_number(1e3 * now.displacement, 1),
                format_number(now.pose.phi.to_degrees(), 1)
            );
            canvas.text(&plan, (layout.plan.rect.left, over), Align::Left, Look::PLAIN)?;
            let side = format!("along the axis:  θ = {}°", format_number(now.tilt.to_degrees(), 1));
            canvas.text(&side, (layout.side.rect.left, over), Align::Left, Look::PLAIN)?;
            self.draw_plan(canvas, layout, index)?;
            self.draw_side(canvas, &layout.side, layout.plate.1, now)?;
            for (axes, below, left) in
                [(&layout.plan, "along the axis, X + x [m]", "y [m]"), (&layout.side, "horizontal [m]", "vertical [m]")]
            {
                axes.frame(canvas)?;
                axes.label_below(canvas, &text::wrap(below, axes.rect.width(), SIZE, false, 1))?;
                axes.label_left(canvas, &[left.to_owned()], tick_width(&axes.y) + 6.0)?;
            }
            Ok(())
        })
    }

    /// The view along the normal, in which the plate moves to and fro.
    fn draw_plan(&self, canvas: &Canvas, layout: &Layout, index: usize) -> Result<()> {
        let now = &self.snapshots[index];
        let axes = &layout.plan;
        let place = |(x, y): (f64, f64)| axes.page((x + now.displacement, y));
        let ((x_low, x_high), (y_low, y_high)) = layout.plate;
        let (left, top) = place((x_low, y_high));
        let (right, bottom) = place((x_high, y_low));
        let plate = Rect { left, top, right, bottom };
        canvas.rect(plate, PLATE)?;
        canvas.border(plate, Stroke::solid(Color::GRAY, 1.0))?;
        // Crosses on the plate make its motion visible.
        let faint = Stroke::solid(Color(190, 190, 190), 1.0);
        let ticks = |low: f64, high: f64| Scale::new(low, high, 5.0, false).ticks.into_iter().map(|t| t.0);
        for x in ticks(x_low, x_high) {
            for y in ticks(y_low, y_high) {
                let (u, v) = place((x, y));
                canvas.line(&[(u - 3.0, v), (u + 3.0, v)], faint)?;
                canvas.line(&[(u, v - 3.0), (u, v + 3.0)], faint)?;
            }
        }
        let axis = Stroke { color: Color::GRAY, width: 1.0, dash: Dash::DashDot };
        canvas.line(&[place((x_low, 0.0)), place((x_high, 0.0))], axis)?;
        let shape = self.outline.points();
        let nose = self.outline.nose();
        let rim = |pose: Pose| -> Vec<(f64, f64)> { shape.iter().map(|q| place(pose.place(*q))).collect() };
        let color = self.categories[now.category].1;
        canvas.polygon(&rim(now.pose), fill(color))?;
        canvas.line(&rim(now.pose), Stroke::solid(color, 2.0))?;
        if let Some(target) = self.target {
            canvas.line(&rim(target), target_stroke())?;
            let ends = [0.82 * nose, nose].map(|u| place(target.place((u, 0.0))));
            canvas.line(&ends, target_stroke())?;
        }
        let trail: Vec<_> = if self.path.is_empty() {
            self.snapshots[..=index].iter().map(|s| place((s.pose.x, s.pose.y))).collect()
        } else {
            self.path.iter().take_while(|p| p.0 <= now.time).map(|p| place((p.1, p.2))).collect()
        };
        canvas.line(&simplify(&decimate(&trail, COLUMN), TOLERANCE), Stroke::solid(self.trail, 1.75))?;
        let tip = place(now.pose.place((nose, 0.0)));
        canvas.line(&[place((now.pose.x, now.pose.y)), tip], Stroke::solid(Color::INK, 1.5))?;
        canvas.disk(tip, 4.0, Color::INK)?;
        let center = place((now.pose.x, now.pose.y));
        match self.end_at(index) {
            Some(_) => Marker::Cross.draw_rimmed(canvas, center),
            None => canvas.disk(center, 2.5, Color::INK),
        }
    }

    /// What happens at a snapshot: something at the last one only.
    fn end_at(&self, index: usize) -> Option<&str> {
        self.end.as_deref().filter(|_| index + 1 == self.snapshots.len())
    }

    /// The view along the axis: the plate as a line, the object on it as thick as it is (but to be seen).
    fn draw_side(&self, canvas: &Canvas, axes: &Axes, (y_low, y_high): (f64, f64), now: &Snapshot) -> Result<()> {
        let (s, c) = now.tilt.sin_cos();
        let place = |y: f64, z: f64| axes.page((y * c - z * s, y * s + z * c));
        let level = Stroke { color: Color::GRAY, width: 1.0, dash: Dash::DashDot };
        let middle = axes.page_y(0.0);
        canvas.line(&[(axes.rect.left, middle), (axes.rect.right, middle)], level)?;
        let per_unit = axes.rect.height() / (axes.y.high - axes.y.low);
        let thick = self.thickness.max(THINNEST / per_unit);
        let (least, most) = self
            .outline
            .points()
            .into_iter()
            .map(|q| now.pose.place(q).1 - now.pose.y)
            .fold((0.0f64, 0.0f64), |(l, h), y| (l.min(y), h.max(y)));
        let (ls, lc) = now.lean.sin_cos();
        let corner = |v: f64, z: f64| {
            let z = z - 0.5 * thick;
            place(now.pose.y + v * lc - z * ls, now.gap + 0.5 * thick + v * ls + z * lc)
        };
        let object = [corner(least, 0.0), corner(most, 0.0), corner(most, thick), corner(least, thick)];
        let color = self.categories[now.category].1;
        canvas.polygon(&object, color)?;
        canvas.line(&[place(y_low, 0.0), place(y_high, 0.0)], Stroke::solid(Color::INK, 2.0))?;
        canvas.disk(axes.page((0.0, 0.0)), 3.5, Color::INK)
    }
}

/// The color of the object's surface.
fn fill(color: Color) -> Color {
    color.mix(Color(255, 255, 255), 0.6)
}

fn target_stroke() -> Stroke {
    Stroke { color: Color::INK, width: 1.5, dash: Dash::Dashed }
}
