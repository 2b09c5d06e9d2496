//! Simple polygons: checks, moments, triangles.

use serde::{Deserialize, Serialize};
use std::ops::Deref;
use std::sync::Arc;

/// What a polygon cannot be.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// Less than three vertices.
    #[error("a polygon needs at least 3 vertices, not {count}")]
    TooFewVertices {
        /// How many there are.
        count: usize,
    },
    /// A vertex that is not finite.
    #[error("vertex {index} of the polygon is not finite")]
    NotFinite {
        /// Index of the vertex.
        index: usize,
    },
    /// A vertex that coincides with the next one.
    #[error("vertices {index} and {next} of the polygon coincide; give each corner once")]
    Coincident {
        /// Index of the vertex.
        index: usize,
        /// Index of the one after it.
        next: usize,
    },
    /// Two sides that meet although they are no neighbors, or neighbors that overlap.
    #[error(
        "the sides of the polygon that start at the vertices {first} and {second} meet; its outline must not cross itself"
    )]
    SelfIntersecting {
        /// First vertex of one side.
        first: usize,
        /// First vertex of the other.
        second: usize,
    },
    /// All vertices on one line, or so nearly that the area is lost in rounding.
    #[error("the polygon has no area (its area is {area} m²)")]
    NoArea {
        /// Its area in m².
        area: f64,
    },
}

/// Vertices of a simple polygon, counter-clockwise, about its centroid, in meters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>")]
pub struct Vertices {
    points: Arc<[[f64; 2]]>,
    moments: Moments,
}

/// Area and central second moments per area.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moments {
    area: f64,
    xx: f64,
    yy: f64,
    xy: f64,
}

impl Deref for Vertices {
    type Target = [[f64; 2]];
    fn deref(&self) -> &[[f64; 2]] {
        &self.points
    }
}

impl TryFrom<Vec<[f64; 2]>> for Vertices {
    type Error = ShapeError;
    fn try_from(points: Vec<[f64; 2]>) -> Result<Self, ShapeError> {
        Self::new(&points)
    }
}

impl From<Vertices> for Vec<[f64; 2]> {
    fn from(vertices: Vertices) -> Self {
        vertices.to_vec()
    }
}

/// Twice the signed area of the triangle `a b c`.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether the segments `a b` and `c d` have a point in common.
fn meet(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> bool {
    let between =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (0..2).all(|i| r[i] >= p[i].min(q[i]) && r[i] <= p[i].max(q[i]));
    let (abc, abd, cda, cdb) = (cross(a, b, c), cross(a, b, d), cross(c, d, a), cross(c, d, b));
    if (abc > 0.0) != (abd > 0.0) && (cda > 0.0) != (cdb > 0.0) && abc * abd * cda * cdb != 0.0 {
        return true;
    }
    (abc == 0.0 && between(a, b, c))
        || (abd == 0.0 && between(a, b, d))
        || (cda == 0.0 && between(c, d, a))
        || (cdb == 0.0 && between(c, d, b))
}

impl Vertices {
    pub(crate) fn new(points: &[[f64; 2]]) -> Result<Self, ShapeError> {
        let n = points.len();
        if n < 3 {
            return Err(ShapeError::TooFewVertices { count: n });
        }
        if let Some(index) = points.iter().position(|p| !(p[0].is_finite() && p[1].is_finite())) {
            return Err(ShapeError::NotFinite { index });
        }
        if let Some(index) = (0..n).find(|&i| points[i] == points[(i + 1) % n]) {
            return Err(ShapeError::Coincident { index, next: (index + 1) % n });
        }
        let size = extent(points);
        let area = signed_area(points);
        if area.abs() <= 1e-9 * size * size || !area.is_finite() {
            return Err(ShapeError::NoArea { area: area.abs() });
        }
        for first in 0..n {
            let [a, b, next] = [0, 1, 2].map(|k| points[(first + k) % n]);
            // Neighbors share a corner; they overlap if the outline turns right back.
            let back = (next[0] - b[0]) * (a[0] - b[0]) + (next[1] - b[1]) * (a[1] - b[1]) > 0.0;
            if cross(a, b, next) == 0.0 && back {
                return Err(ShapeError::SelfIntersecting { first, second: (first + 1) % n });
            }
            for second in first + 2..n {
                if (second + 1) % n != first && meet(a, b, points[second], points[(second + 1) % n]) {
                    return Err(ShapeError::SelfIntersecting { first, second });
                }
            }
        }
        let mut ordered = points.to_vec();
        if area < 0.0 {
            ordered.reverse();
        }
        // Twice: the second time removes the rounding of an origin far away.
        for _ in 0..2 {
            let centroid = centroid(&ordered);
            for point in &mut ordered {
                *point = [point[0] - centroid[0], point[1] - centroid[1]];
            }
        }
        Ok(Self { moments: second_moments(&ordered), points: ordered.into() })
    }

    pub(crate) fn area(&self) -> f64 {
        self.moments.area
    }

    /// Principal moments per area, the greater first, and the angle of its axis.
    pub(crate) fn principal(&self) -> ((f64, f64), f64) {
        let Moments { xx, yy, xy, .. } = self.moments;
        let (mean, half, size) = (0.5 * (xx + yy), 0.5 * (xx - yy), xx + yy);
        let radius = half.hypot(xy);
        // Equal moments up to rounding have no direction; axes that coincide with the own ones up to rounding do so.
        let turn =
            if radius <= 1e-12 * size || (xy.abs() <= 1e-12 * size && half > 0.0) { 0.0 } else { 0.5 * xy.atan2(half) };
        ((mean + radius, mean - radius), turn)
    }

    pub(crate) fn contains(&self, p: [f64; 2]) -> bool {
        let n = self.len();
        let mut inside = false;
        for i in 0..n {
            let (a, b) = (self[i], self[(i + 1) % n]);
            if cross(a, b, p) == 0.0 && meet(a, b, p, p) {
                return true;
            }
            if (a[1] > p[1]) != (b[1] > p[1]) {
                let x = a[0] + (p[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]);
                inside ^= p[0] < x;
            }
        }
        inside
    }

    pub(crate) fn support(&self, direction: [f64; 2]) -> [f64; 2] {
        let along = |p: &[f64; 2]| p[0] * direction[0] + p[1] * direction[1];
        let mut best = self[0];
        for point in self.iter() {
            if along(point) > along(&best) {
                best = *point;
            }
        }
        best
    }

    /// Share of the way from the origin to the rim of the convex hull: the greatest `n · p/(n · corner)` over the sides of
    /// the hull with normal `n`.
    pub(crate) fn hull_share(&self, p: [f64; 2]) -> f64 {
        let mut share = 0.0f64;
        for &a in self.iter() {
            for &b in self.iter() {
                let normal = [b[1] - a[1], a[0] - b[0]];
                let rim = normal[0] * a[0] + normal[1] * a[1];
                let size = normal[0].hypot(normal[1]) * a[0].hypot(a[1]);
                let side = a != b && self.iter().all(|c| normal[0] * c[0] + normal[1] * c[1] <= rim + 1e-12 * size);
                if side {
                    share = share.max((normal[0] * p[0] + normal[1] * p[1]) / rim);
                }
            }
        }
        share
    }

    /// Triangles that cover the polygon, by clipping ears.
    pub(crate) fn triangles(&self) -> Vec<[[f64; 2]; 3]> {
        let mut rest: Vec<[f64; 2]> = self.to_vec();
        let mut triangles = Vec::with_capacity(rest.len() - 2);
        while rest.len() > 3 {
            let n = rest.len();
            let corner = |i: usize| [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]];
            let is_ear = |i: usize| {
                let [a, b, c] = corner(i);
                let holds = |p: &[f64; 2]| cross(a, b, *p) >= 0.0 && cross(b, c, *p) >= 0.0 && cross(c, a, *p) >= 0.0;
                cross(a, b, c) > 0.0 && !rest.iter().any(|p| *p != a && *p != b && *p != c && holds(p))
            };
            // A corner without area can be left out; a simple polygon has an ear; rounding may hide it, then the widest
            // corner is taken.
            let flat = (0..n).find(|&i| cross(corner(i)[0], corner(i)[1], corner(i)[2]) == 0.0);
            let ear = flat.or_else(|| (0..n).find(|&i| is_ear(i))).unwrap_or_else(|| {
                let area = |i: usize| cross(corner(i)[0], corner(i)[1], corner(i)[2]);
                (0..n).max_by(|&i, &j| area(i).total_cmp(&area(j))).unwrap_or(0)
            });
            if flat.is_none() {
                triangles.push(corner(ear));
            }
            rest.remove(ear);
        }
        triangles.extend(<[[f64; 2]; 3]>::try_from(rest));
        triangles
    }
}

fn extent(points: &[[f64; 2]]) -> f64 {
    let from = points[0];
    points.iter().map(|p| (p[0] - from[0]).hypot(p[1] - from[1])).fold(0.0, f64::max)
}

/// Triangles from the first vertex to each side, with the vectors from it and twice the signed area.
fn fan(points: &[[f64; 2]]) -> impl Iterator<Item = ([f64; 2], [f64; 2], f64)> {
    let from = points[0];
    points.windows(2).skip(1).map(move |side| {
        let relative = |p: [f64; 2]| [p[0] - from[0], p[1] - from[1]];
        let (p, q) = (relative(side[0]), relative(side[1]));
        (p, q, p[0] * q[1] - p[1] * q[0])
    })
}

fn signed_area(points: &[[f64; 2]]) -> f64 {
    0.5 * fan(points).map(|(_, _, double)| double).sum::<f64>()
}

fn centroid(points: &[[f64; 2]]) -> [f64; 2] {
    let (mut area, mut first) = (0.0, [0.0; 2]);
    for (p, q, double) in fan(points) {
        area += double;
        for i in 0..2 {
            first[i] += double * (p[i] + q[i]) / 3.0;
        }
    }
    [points[0][0] + first[0] / area, points[0][1] + first[1] / area]
}

/// Moments about the origin, which is the centroid: `∫ x² dA = Σ D/12 (x_i² + x_i x_j + x_j²)` over the triangles of the
/// origin with each side, `D = x_i y_j − x_j y_i`.
fn second_moments(points: &[[f64; 2]]) -> Moments {
    let mut sums = [0.0; 4];
    for (p, q) in points.iter().zip(points.iter().cycle().skip(1)) {
        let double = p[0] * q[1] - p[1] * q[0];
        sums[0] += 0.5 * double;
        sums[1] += double / 12.0 * (p[0] * p[0] + p[0] * q[0] + q[0] * q[0]);
        sums[2] += double / 12.0 * (p[1] * p[1] + p[1] * q[1] + q[1] * q[1]);
        sums[3] += double / 24.0 * (2.0 * p[0] * p[1] + p[0] * q[1] + q[0] * p[1] + 2.0 * q[0] * q[1]);
    }
    Moments { area: sums[0], xx: sums[1] / sums[0], yy: sums[2] / sums[0], xy: sums[3] / sums[0] }
}
