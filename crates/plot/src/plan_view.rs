//! Views from above: an object moving in the plane.

use crate::axes::{Axes, TICK_ROOM, Title, horizontal_scale, tick_width};
use crate::canvas::{Canvas, Dash, Rect, Stroke, paint};
use crate::color::Color;
use crate::decimate::{decimate, simplify};
use crate::drawing::Drawing;
use crate::error::{PlotError, Result, check_finite};
use crate::legend::{Legend, Marker, Sample};
use crate::motion::{Outline, Pose, RecordedMotion};
use crate::panel::{COLUMN, TOLERANCE};
use crate::reading;
use crate::setters::setters;
use crate::stack::{BORDER, LEGEND_GAP, RIGHT, WIDTH};
use crate::text::{self, LEADING, SIZE};
use crate::ticks::{Scale, padded_range, short};

/// One view: trajectories over each other, of one object.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Title; may be empty.
    pub title: String,
    /// The object's shape.
    pub outline: Outline,
    /// The motions, each in a color of its own.
    pub trajectories: Vec<RecordedMotion>,
    /// Where the object should arrive.
    pub target: Option<Pose>,
    /// Unit of the times; empty for none.
    pub time_unit: String,
}

impl Scene {
    /// A view of an object of this shape, still without motions.
    pub fn new(title: impl Into<String>, outline: Outline) -> Self {
        Self { title: title.into(), outline, trajectories: Vec::new(), target: None, time_unit: "s".to_owned() }
    }

    setters! {
        /// Adds a motion.
        trajectory(trajectory: RecordedMotion) |it| it.trajectories.push(trajectory);
        /// Sets the pose to be reached.
        target(pose: Pose) |it| it.target = Some(pose);
        /// Sets the unit of the times, which are seconds otherwise; empty for none.
        time_unit(unit: impl Into<String>) |it| it.time_unit = unit.into();
    }

    fn check(&self) -> Result<()> {
        let (u, v): (Vec<f64>, Vec<f64>) = self.outline.points().into_iter().unzip();
        let outline = format!("outline of {}", self.title);
        check_finite(&outline, &u)?;
        check_finite(&outline, &v)?;
        if let Some(p) = self.target {
            check_finite(&format!("target of {}", self.title), &[p.x, p.y, p.phi])?;
        }
        self.trajectories.iter().try_for_each(RecordedMotion::check)
    }

    /// All points that the view should show.
    fn extent(&self, stamps: usize) -> Vec<(f64, f64)> {
        let shape = self.outline.points();
        let paths = self.trajectories.iter().flat_map(|t| t.x.iter().copied().zip(t.y.iter().copied()));
        let stamped = self.trajectories.iter().flat_map(|t| t.stamps(stamps).into_iter().map(|k| t.pose(k)));
        let poses: Vec<Pose> = stamped.chain(self.target).collect();
        let outlines = poses.iter().flat_map(|p| {
            let corners = shape.iter().map(|q| p.place(*q));
            corners.chain([(p.x, p.y)])
        });
        paths.chain(outlines).collect()
    }

    fn color(&self, index: usize) -> Color {
        self.trajectories[index].color.unwrap_or_else(|| Color::series(index))
    }

    /// How much broader a motion is drawn than the last one, which lies over it and must not hide it.
    fn breadth(&self, index: usize) -> f64 {
        1.0 + 0.9 * (self.trajectories.len() - 1 - index).min(2) as f64
    }

    /// Legend of the motions.
    fn entries(&self) -> Vec<(Sample, String)> {
        let entry = |(k, trajectory): (usize, &RecordedMotion)| {
            let (start, end) = trajectory.span()?;
            let unit = if self.time_unit.is_empty() { String::new() } else { format!("\u{a0}{}", self.time_unit) };
            let times = format!("{}\u{a0}to\u{a0}{}{unit}", short(start), short(end));
            let name = match trajectory.name.as_str() {
                "" => times,
                name => format!("{name}, {times}"),
            };
            Some((Sample::Ramp(self.color(k), 3.0 * self.breadth(k)), name))
        };
        self.trajectories.iter().enumerate().filter_map(entry).collect()
    }

    fn draw(&self, canvas: &Canvas, axes: &Axes, stamps: usize) -> Result<()> {
        let shape = self.outline.points();
        let nose = self.outline.nose();
        let rim = |pose: Pose| -> Vec<(f64, f64)> { shape.iter().map(|q| axes.page(pose.place(*q))).collect() };
        let heading = |pose: Pose, color: Color, radius: f64, marker: Marker| {
            let tip = axes.page(pose.place((nose, 0.0)));
            if nose > 0.0 {
                canvas.line(&[axes.page(pose.place((0.82 * nose, 0.0))), tip], Stroke::solid(color, 1.5))?;
            }
            marker.draw_sized(canvas, tip, radius, color)
        };
        for (k, trajectory) in self.trajectories.iter().enumerate() {
            let marks = trajectory.stamps(stamps);
            let last = marks.len().saturating_sub(1);
            for (i, sample) in marks.iter().enumerate() {
                let color = self.color(k).shade(trajectory.fraction(*sample));
                let pose = trajectory.pose(*sample);
                let width = self.breadth(k) * if i == last { 2.25 } else { 1.0 };
                if i > 0 {
                    canvas.line(&rim(pose), Stroke::solid(color, width))?;
                    heading(pose, color, if i == last { 4.0 } else { 2.5 }, Marker::series(k))?;
                }
            }
            self.draw_path(canvas, axes, k)?;
            for sample in marks {
                let color = self.color(k).shade(trajectory.fraction(sample));
                canvas.disk(axes.page((trajectory.x[sample], trajectory.y[sample])), 2.5, color)?;
            }
        }
        for trajectory in self.trajectories.iter().filter(|t| !t.time.is_empty()) {
            let start = trajectory.pose(0);
            canvas.line(&rim(start), start_stroke())?;
            heading(start, start_stroke().color, 4.0, Marker::Disk)?;
        }
        if let Some(target) = self.target {
            canvas.line(&rim(target), target_stroke())?;
            heading(target, target_stroke().color, 4.0, Marker::Disk)?;
            let (x, y) = axes.page((target.x, target.y));
            let stroke = Stroke::solid(target_stroke().color, 1.5);
            canvas.line(&[(x - 6.0, y), (x + 6.0, y)], stroke)?;
            canvas.line(&[(x, y - 6.0), (x, y + 6.0)], stroke)?;
        }
        for trajectory in self.trajectories.iter().filter(|t| t.end.is_some() && !t.time.is_empty()) {
            let end = trajectory.pose(trajectory.time.len() - 1);
            Marker::Cross.draw_rimmed(canvas, axes.page((end.x, end.y)))?;
        }
        Ok(())
    }

    /// The path of the object's center, shaded by time.
    fn draw_path(&self, canvas: &Canvas, axes: &Axes, index: usize) -> Result<()> {
        const SHADES: f64 = 24.0;
        let trajectory = &self.trajectories[index];
        let place = |k: usize| axes.page((trajectory.x[k], trajectory.y[k]));
        let shade = |k: usize| (trajectory.fraction(k) * SHADES).floor();
        let mut start = 0;
        for k in 1..trajectory.time.len() {
            if shade(k) != shade(start) || k + 1 == trajectory.time.len() {
                let piece: Vec<_> = (start..=k).map(place).collect();
                let stroke =
                    Stroke::solid(self.color(index).shade(trajectory.fraction(start)), 2.0 * self.breadth(index));
                canvas.line(&simplify(&decimate(&piece, COLUMN), TOLERANCE), stroke)?;
                start = k;
            }
        }
        Ok(())
    }
}

fn start_stroke() -> Stroke {
    Stroke { color: Color::GRAY, width: 2.0, dash: Dash::Dotted }
}

fn target_stroke() -> Stroke {
    Stroke { color: Color::INK, width: 2.0, dash: Dash::Dashed }
}

/// Views from above with equal scales on both axes, side by side where there are several.
///
/// ```
/// use bracketry_plot::{Outline, PlanView, Pose, Scene, RecordedMotion};
/// let motion = RecordedMotion::new("push", [0.0, 1.0], [0.48, 0.54], [-0.03, 0.0], [0.0, 1.57]);
/// let scene = Scene::new("Simultaneous", Outline::Ellipse { a: 0.15, b: 0.1 })
///     .trajectory(motion)
///     .target(Pose::new(0.54, 0.0, 1.57));
/// let drawing = PlanView::new().scene(scene).draw()?;
/// assert!(drawing.svg().contains("Simultaneous"));
/// # Ok::<(), bracketry_plot::PlotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct PlanView {
    /// Title; empty for none.
    pub title: String,
    /// Label of the horizontal axis.
    pub x_label: String,
    /// Label of the vertical axis.
    pub y_label: String,
    /// The views, from left to right, two or three in a row.
    pub scenes: Vec<Scene>,
    /// Number of equal time steps after each of which the outline is drawn, 1 to 200.
    pub stamps: usize,
}

impl Default for PlanView {
    fn default() -> Self {
        Self::new()
    }
}

impl PlanView {
    /// A figure without views, with axes `x [m]` and `y [m]` and the outline drawn at six equal time steps.
    pub fn new() -> Self {
        Self {
            title: String::new(),
            x_label: "x [m]".to_owned(),
            y_label: "y [m]".to_owned(),
            scenes: Vec::new(),
            stamps: 6,
        }
    }

    setters! {
        /// Sets the title.
        title(title: impl Into<String>) |it| it.title = title.into();
        /// Sets the labels of the axes.
        labels(x: impl Into<String>, y: impl Into<String>) |it| (it.x_label, it.y_label) = (x.into(), y.into());
        /// Adds a view.
        scene(scene: Scene) |it| it.scenes.push(scene);
        /// Sets after how many equal time steps the outline is drawn.
        stamps(count: usize) |it| it.stamps = count;
    }

    /// Legend of what all views share.
    fn common_entries(&self) -> Vec<(Sample, String)> {
        // Objects without extent have neither outline nor heading: dots mark where they start and should arrive.
        let shaped = self.scenes.iter().any(|s| s.outline.nose() > 0.0);
        let mark = |stroke: Stroke| if shaped { Sample::Line(stroke, None) } else { Sample::Dot(stroke.color) };
        let mut shared = Vec::new();
        if self.scenes.iter().any(|s| s.trajectories.iter().any(|t| !t.time.is_empty())) {
            shared.push((mark(start_stroke()), "start".to_owned()));
            if shaped {
                shared.push((Sample::Line(Stroke::solid(Color::INK, 2.25), None), "end".to_owned()));
            }
        }
        if self.scenes.iter().any(|s| s.target.is_some()) {
            shared.push((mark(target_stroke()), "target".to_owned()));
        }
        let ends = self.scenes.iter().flat_map(|s| &s.trajectories).filter_map(|t| t.end.as_ref());
        for what in ends {
            if shared.iter().all(|(_, known)| known != what) {
                shared.push((Sample::Mark(Marker::Cross), what.clone()));
            }
        }
        if shaped && !shared.is_empty() {
            shared.push((Sample::Heading(Color::INK), "heading".to_owned()));
        }
        shared
    }

    /// Draws the figure.
    ///
    /// # Errors
    /// [`PlotError::NoContent`] without views; otherwise what is wrong with the data.
    pub fn draw(&self) -> Result<Drawing> {
        if self.scenes.is_empty() {
            return Err(PlotError::NoContent { missing: "scene" });
        }
        self.scenes.iter().try_for_each(Scene::check)?;
        let stamps = self.stamps.clamp(1, 200);
        let columns = if self.scenes.len() == 4 { 2 } else { self.scenes.len().min(3) };
        let max_height = [520.0, 430.0, 340.0][columns - 1];

        // The views share their ranges, so that they can be compared.
        let (x, y): (Vec<f64>, Vec<f64>) = self.scenes.iter().flat_map(|s| s.extent(stamps)).unzip();
        let (x, y) = (padded_range(x, 0.06), padded_range(y, 0.06));
        let (wide, high) = (x.1 - x.0, y.1 - y.0);
        let cell = (WIDTH - BORDER) / columns as f64;
        // The final vertical range may be wider, to fill its height: leave room for such labels.
        let tallest = Scale::new(y.0 - high, y.1 + high, 12.0, false);
        let label_gap = tick_width(&tallest).max(tick_width(&Scale::new(y.0, y.1, 6.0, false))) + 6.0;
        let margin = label_gap + SIZE * LEADING;
        let width = cell - margin - RIGHT;
        let per_unit = (width / wide).min(max_height / high);
        let height = (high * per_unit).max(120.0);
        let fit = |(low, high): (f64, f64), pixels: f64| {
            let (center, half) = (f64::midpoint(low, high), pixels / per_unit / 2.0);
            (center - half, center + half)
        };

        let x_scale = horizontal_scale(fit(x, width), width, 60.0, false);
        let (low, high) = fit(y, height);
        let y_scale = Scale::new(low, high, height / 60.0, false);

        let title = Title::figure(&self.title, WIDTH - BORDER - RIGHT);
        let titles: Vec<Title> = self.scenes.iter().map(|s| Title::plot(&s.title, width)).collect();
        let legends: Vec<Legend> = self.scenes.iter().map(|s| Legend::new(s.entries(), width)).collect();
        let x_label = text::wrap(&x_scale.label(&self.x_label), width, SIZE, false, 2);
        let y_label = text::wrap(&y_scale.label(&self.y_label), height, SIZE, false, 1);
        let common = Legend::new(self.common_entries(), WIDTH - BORDER - RIGHT - margin);
        let above = |row: usize| {
            let cells = row * columns..((row + 1) * columns).min(self.scenes.len());
            cells.map(|k| titles[k].height() + legends[k].height() + LEGEND_GAP).fold(0.0, f64::max)
        };
        let below = TICK_ROOM + x_label.len() as f64 * SIZE * LEADING + BORDER;
        let rows = self.scenes.len().div_ceil(columns);
        let common_top = BORDER + title.height();
        let mut tops = vec![common_top + common.height() + 4.0];
        for row in 0..rows {
            tops.push(tops[row] + above(row) + height + below);
        }

        paint(WIDTH, tops[rows], |canvas| {
            title.draw(canvas, BORDER, BORDER)?;
            common.draw(canvas, BORDER + margin, common_top)?;
            for (k, scene) in self.scenes.iter().enumerate() {
                let (row, column) = (k / columns, k % columns);
                let left = BORDER + column as f64 * cell + margin;
                let top = tops[row] + above(row);
                let rect = Rect { left, top, right: left + width, bottom: top + height };
                let axes = Axes { rect, x: x_scale.clone(), y: y_scale.clone() };
                let legend_top = top - legends[k].height() - LEGEND_GAP;
                titles[k].draw(canvas, left, legend_top - titles[k].height())?;
                legends[k].draw(canvas, left, legend_top)?;
                axes.grid_x(canvas)?;
                axes.grid_y(canvas)?;
                scene.draw(canvas, &axes, stamps)?;
                reading::panel(canvas, k, &axes, (&self.x_label, &self.y_label));
                axes.frame(canvas)?;
                axes.label_left(canvas, &y_label, tick_width(&axes.y) + 6.0)?;
                axes.label_below(canvas, &x_label)?;
            }
            Ok(())
        })
    }
}
