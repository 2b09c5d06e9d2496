//! Motions in the plane, and the shape of what moves.

use crate::color::Color;
use crate::error::{Result, check_finite, check_lengths};
use crate::role::Role;
use crate::setters::setters;

/// Position and orientation in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// To the right.
    pub x: f64,
    /// Upwards.
    pub y: f64,
    /// Angle from x toward y, in radians.
    pub phi: f64,
}

impl Pose {
    /// The pose at `(x, y)`, rotated by `phi` radians from x toward y.
    pub fn new(x: f64, y: f64, phi: f64) -> Self {
        Self { x, y, phi }
    }

    pub(crate) fn place(self, (u, v): (f64, f64)) -> (f64, f64) {
        let (s, c) = self.phi.sin_cos();
        (self.x + c * u - s * v, self.y + s * u + c * v)
    }
}

/// The shape of the object in its own frame, the heading along the first axis.
#[derive(Debug, Clone, PartialEq)]
pub enum Outline {
    /// An ellipse with semi-axis `a` along the heading and `b` across.
    Ellipse {
        /// Along the heading.
        a: f64,
        /// Across.
        b: f64,
    },
    /// A polygon through these points, closed by itself. Fewer than two points draw no outline.
    Polygon(Vec<(f64, f64)>),
}

impl Outline {
    /// The corners in the object's frame, the first one repeated at the end.
    pub(crate) fn points(&self) -> Vec<(f64, f64)> {
        match self {
            Self::Ellipse { a, b } => (0..=96)
                .map(|k| (f64::from(k) * std::f64::consts::TAU / 96.0).sin_cos())
                .map(|(s, c)| (a * c, b * s))
                .collect(),
            Self::Polygon(points) => points.iter().chain(points.first()).copied().collect(),
        }
    }

    /// Where the heading leaves the outline: the farthest crossing of the first axis.
    pub(crate) fn nose(&self) -> f64 {
        let crossing = |w: &[(f64, f64)]| {
            let ((x0, y0), (x1, y1)) = (w[0], w[1]);
            if y0 * y1 > 0.0 {
                return 0.0;
            }
            if y0 == y1 { x0.max(x1) } else { x0 - y0 * (x1 - x0) / (y1 - y0) }
        };
        self.points().windows(2).map(crossing).fold(0.0, f64::max)
    }
}

/// A recorded motion.
#[derive(Debug, Clone)]
pub struct RecordedMotion {
    /// Name in the legend; may be empty.
    pub name: String,
    /// Times in seconds, not decreasing.
    pub time: Vec<f64>,
    /// Horizontal position at each time.
    pub x: Vec<f64>,
    /// Vertical position at each time.
    pub y: Vec<f64>,
    /// Orientation at each time, in radians from x toward y.
    pub phi: Vec<f64>,
    /// Color, pale to dark with time; `None` takes the next one of [`Color::series`].
    pub color: Option<Color>,
    /// What happens at the end, which gets a cross; none if the motion just ends.
    pub end: Option<String>,
}

impl RecordedMotion {
    /// A motion through `(x[i], y[i], phi[i])` at `time[i]`.
    pub fn new(
        name: impl Into<String>,
        time: impl Into<Vec<f64>>,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
        phi: impl Into<Vec<f64>>,
    ) -> Self {
        Self { name: name.into(), time: time.into(), x: x.into(), y: y.into(), phi: phi.into(), color: None, end: None }
    }

    setters! {
        /// Sets the color.
        color(color: Color) |it| it.color = Some(color);
    }

    /// Sets the color to that of a role.
    #[must_use]
    pub fn role(self, role: Role) -> Self {
        self.color(role.color())
    }

    setters! {
        /// Marks the end with a cross, such as `tips` where the object tips; the legend names it.
        end(what: impl Into<String>) |it| it.end = Some(what.into());
    }

    pub(crate) fn check(&self) -> Result<()> {
        check_finite(&self.name, &self.time)?;
        for column in [&self.x, &self.y, &self.phi] {
            check_lengths(&self.name, self.time.len(), column.len())?;
            check_finite(&self.name, column)?;
        }
        Ok(())
    }

    pub(crate) fn pose(&self, k: usize) -> Pose {
        Pose::new(self.x[k], self.y[k], self.phi[k])
    }

    /// First and last time.
    pub(crate) fn span(&self) -> Option<(f64, f64)> {
        self.time.first().copied().zip(self.time.last().copied())
    }

    /// Fraction of the whole time at sample `k`.
    pub(crate) fn fraction(&self, k: usize) -> f64 {
        match self.span() {
            Some((start, end)) if end > start => (self.time[k] - start) / (end - start),
            _ => 1.0,
        }
    }

    /// Samples nearest to `count + 1` times equally far apart.
    pub(crate) fn stamps(&self, count: usize) -> Vec<usize> {
        let Some((start, end)) = self.span() else {
            return Vec::new();
        };
        let mut stamps: Vec<usize> = (0..=count)
            .map(|k| {
                let t = start + (end - start) * k as f64 / count.max(1) as f64;
                let after = self.time.partition_point(|v| *v < t).min(self.time.len() - 1);
                let before = after.saturating_sub(1);
                if t - self.time[before] < self.time[after] - t { before } else { after }
            })
            .collect();
        stamps.dedup();
        stamps
    }
}
