//! Shapes of the object on the plate.

use super::polygon::{ShapeError, Vertices};
use super::quadrature::{self, Quadrature};
use crate::PlateError;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A uniform flat object. Its own axes have their origin at the centroid.
///
/// ```
/// use bracketry_plate::Shape;
/// let rectangle = Shape::Rectangle { a: 0.15, b: 0.10 };
/// let polygon = Shape::polygon(&[[0.0, 0.0], [0.3, 0.0], [0.3, 0.2], [0.0, 0.2]]).unwrap();
/// let ((sa, sb), (pa, pb)) = (rectangle.second_moments(), polygon.second_moments());
/// assert!((sa - pa).abs() < 1e-15 && (sb - pb).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Shape {
    /// An ellipse with semi-axis `a` along its own x and `b` along its own y, in meters.
    Ellipse {
        /// Semi-axis along x.
        a: f64,
        /// Semi-axis along y.
        b: f64,
    },
    /// A disk, radius in meters.
    Disk {
        /// Radius.
        radius: f64,
    },
    /// A rectangle with half-side `a` along its own x and `b` along its own y, in meters.
    Rectangle {
        /// Half-side along x.
        a: f64,
        /// Half-side along y.
        b: f64,
    },
    /// A simple polygon; see [`Shape::polygon`].
    Polygon {
        /// Vertices in meters, counter-clockwise, about the centroid.
        vertices: Vertices,
    },
}

impl Shape {
    /// The ellipse of the reference results, 0.15 m × 0.10 m.
    pub const REFERENCE_ELLIPSE: Shape = Shape::Ellipse { a: 0.15, b: 0.10 };
    /// The disk of the reference results, radius 0.12 m.
    pub const REFERENCE_DISK: Shape = Shape::Disk { radius: 0.12 };

    /// The polygon with the vertices in order, in either orientation, in meters. The origin is moved to the centroid; the axes
    /// keep their directions, so that the principal axes are rotated by [`Shape::principal_angle`].
    ///
    /// # Errors
    /// [`ShapeError`] if there are less than three vertices, one is not finite, two neighbors coincide, the area vanishes
    /// or the outline meets itself.
    pub fn polygon(vertices: &[[f64; 2]]) -> Result<Self, ShapeError> {
        Ok(Self::Polygon { vertices: Vertices::new(vertices)? })
    }

    /// Checks that the lengths are positive and finite.
    ///
    /// # Errors
    /// [`PlateError::BadNumber`] for one that is not.
    pub fn validate(&self) -> Result<(), PlateError> {
        let lengths = match *self {
            Shape::Ellipse { a, b } | Shape::Rectangle { a, b } => [("a", a), ("b", b)],
            Shape::Disk { radius } => [("radius", radius); 2],
            // Checked when they were made.
            Shape::Polygon { .. } => return Ok(()),
        };
        for (name, value) in lengths {
            if !(value.is_finite() && value > 0.0) {
                return Err(PlateError::BadNumber { name, value });
            }
        }
        Ok(())
    }

    /// Area in m².
    pub fn area(&self) -> f64 {
        match self {
            Shape::Ellipse { a, b } => 0.5 * TAU * a * b,
            Shape::Disk { radius } => 0.5 * TAU * radius * radius,
            Shape::Rectangle { a, b } => 4.0 * a * b,
            Shape::Polygon { vertices } => vertices.area(),
        }
    }

    /// Principal second moments per mass `(Sa, Sb)` in m²: along the object's own axes `a²/4`, `b²/4` for an ellipse and
    /// `a²/3`, `b²/3` for a rectangle; of a polygon `Sa ≥ Sb`, along axes rotated by [`Shape::principal_angle`].
    ///
    /// ```
    /// use bracketry_plate::Shape;
    /// assert_eq!(Shape::Ellipse { a: 2.0, b: 1.0 }.second_moments(), (1.0, 0.25));
    /// ```
    pub fn second_moments(&self) -> (f64, f64) {
        match self {
            Shape::Ellipse { a, b } => (a * a / 4.0, b * b / 4.0),
            Shape::Disk { radius } => (radius * radius / 4.0, radius * radius / 4.0),
            Shape::Rectangle { a, b } => (a * a / 3.0, b * b / 3.0),
            Shape::Polygon { vertices } => vertices.principal().0,
        }
    }

    /// Angle from the object's own x axis to the principal axis of `Sa`, in radians; 0 for all shapes but polygons.
    pub fn principal_angle(&self) -> f64 {
        match self {
            Shape::Polygon { vertices } => vertices.principal().1,
            _ => 0.0,
        }
    }

    /// Second moments per mass in plate axes at yaw `phi`, `(Sxx, Syy, Sxy)`: `Sxx = c²Sa + s²Sb`, `Syy = s²Sa + c²Sb`,
    /// `Sxy = c s (Sa − Sb)`, `c` and `s` of `phi` plus the principal angle.
    pub fn second_moments_at(&self, phi: f64) -> (f64, f64, f64) {
        let (sa, sb) = self.second_moments();
        let (s, c) = (phi + self.principal_angle()).sin_cos();
        (c * c * sa + s * s * sb, s * s * sa + c * c * sb, c * s * (sa - sb))
    }

    /// Yaw inertia per mass `Sa + Sb` in m².
    pub fn yaw_inertia(&self) -> f64 {
        let (sa, sb) = self.second_moments();
        sa + sb
    }

    /// Whether the point (own axes, m) lies in the shape or on its rim.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        let [x, y] = point;
        match self {
            Shape::Ellipse { a, b } => (x / a).hypot(y / b) <= 1.0,
            Shape::Disk { radius } => x.hypot(y) <= *radius,
            Shape::Rectangle { a, b } => x.abs() <= *a && y.abs() <= *b,
            Shape::Polygon { vertices } => vertices.contains(point),
        }
    }

    /// The point of the shape farthest along `direction`, own axes, in m: the support function of the convex hull.
    pub fn support(&self, direction: [f64; 2]) -> [f64; 2] {
        let [dx, dy] = direction;
        let ellipse = |a: f64, b: f64| {
            let length = (a * dx).hypot(b * dy);
            if length > 0.0 { [a * a * dx / length, b * b * dy / length] } else { [a, 0.0] }
        };
        match self {
            Shape::Ellipse { a, b } => ellipse(*a, *b),
            Shape::Disk { radius } => ellipse(*radius, *radius),
            Shape::Rectangle { a, b } => [a.copysign(dx), b.copysign(dy)],
            Shape::Polygon { vertices } => vertices.support(direction),
        }
    }

    /// Share of the way from the centroid to the rim of the convex hull at which `point` lies: below 1 inside, 1 on the rim.
    /// A plane support carries a load whose center of pressure has a share below 1.
    pub fn rim_share(&self, point: [f64; 2]) -> f64 {
        let [x, y] = point;
        match self {
            Shape::Ellipse { a, b } => (x / a).hypot(y / b),
            Shape::Disk { radius } => x.hypot(y) / radius,
            Shape::Rectangle { a, b } => (x / a).abs().max((y / b).abs()),
            Shape::Polygon { vertices } => vertices.hull_share(point),
        }
    }

    /// `count` points of the rim, own axes, in m: at equal angles of the parameter of an ellipse, at equal distances along
    /// the sides otherwise (at least every corner).
    pub fn rim(&self, count: usize) -> Vec<[f64; 2]> {
        let ellipse = |a: f64, b: f64| {
            let angle = |i| TAU * i as f64 / count.max(1) as f64;
            (0..count).map(|i| [a * angle(i).cos(), b * angle(i).sin()]).collect()
        };
        match self {
            Shape::Ellipse { a, b } => ellipse(*a, *b),
            Shape::Disk { radius } => ellipse(*radius, *radius),
            Shape::Rectangle { a, b } => along(&[[*a, *b], [-a, *b], [-a, -b], [*a, -b]], count),
            Shape::Polygon { vertices } => along(vertices, count),
        }
    }

    /// About `count` points with weights for means over the area: `∫ f dA / A ≈ Σ w f(r)`. The weights are positive and sum
    /// to 1; area, centroid and second moments are exact. See [`Quadrature`].
    ///
    /// # Errors
    /// [`PlateError::BadNumber`] for a length without meaning; [`PlateError::TooFewPoints`] for less than 4 points.
    pub fn quadrature(&self, count: usize) -> Result<Quadrature, PlateError> {
        self.validate()?;
        if count < 4 {
            return Err(PlateError::TooFewPoints { count, least: 4 });
        }
        Ok(match self {
            Shape::Ellipse { a, b } => quadrature::ellipse(*a, *b, count),
            Shape::Disk { radius } => quadrature::ellipse(*radius, *radius, count),
            Shape::Rectangle { a, b } => quadrature::rectangle(*a, *b, count),
            Shape::Polygon { vertices } => quadrature::triangles(vertices.triangles(), count),
        })
    }
}

/// Points at about equal distances along a closed polygon, corners included.
fn along(corners: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let length = |a: &[f64; 2], b: &[f64; 2]| (b[0] - a[0]).hypot(b[1] - a[1]);
    let around: f64 = sides.clone().map(|(a, b)| length(a, b)).sum();
    let mut points = Vec::with_capacity(count + corners.len());
    for (a, b) in sides {
        let parts = (count as f64 * length(a, b) / around).round().max(1.0);
        for i in 0..parts as usize {
            let share = i as f64 / parts;
            points.push([a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]);
        }
    }
    points
}
