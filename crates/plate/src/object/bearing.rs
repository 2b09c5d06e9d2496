//! Where an object presses on the plate, apart from where its mass is.

use super::prism::Object;
use super::quadrature::Quadrature;
use super::shape::Shape;
use crate::PlateError;
use serde::{Deserialize, Serialize};

/// The part of an object that presses on the plate. Points are in the object's own axes from the center of its shape, in m.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub enum Bearing {
    /// The whole footprint.
    #[default]
    Footprint,
    /// The footprint scaled about its center: 0.5 is its inner half. A number above 1 is an equivalent of pressure that stands
    /// on the rim.
    Scaled(f64),
    /// A thin ring: the rim scaled about the center, evenly by length. The number is 1 for the rim itself.
    Ring(f64),
    /// Feet of equal stiffness.
    Feet(Vec<[f64; 2]>),
    /// A map of points `x, y, weight`: the weight is the share in a load without moments about the mean point.
    Map(Vec<[f64; 3]>),
}

impl Bearing {
    /// The same pattern scaled about the center of the shape.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        match self {
            Self::Footprint => Self::Scaled(factor),
            Self::Scaled(scale) => Self::Scaled(factor * scale),
            Self::Ring(scale) => Self::Ring(factor * scale),
            Self::Feet(points) => Self::Feet(points.iter().map(|p| p.map(|x| factor * x)).collect()),
            Self::Map(points) => Self::Map(points.iter().map(|[x, y, w]| [factor * x, factor * y, *w]).collect()),
        }
    }

    /// Points with shares of sum 1 from the center of the shape, about `count` where the pattern is not a list.
    fn rule(&self, shape: &Shape, count: usize) -> Result<Quadrature, PlateError> {
        let positive = |name: &'static str, value: f64| {
            if value.is_finite() && value > 0.0 { Ok(()) } else { Err(PlateError::BadNumber { name, value }) }
        };
        let shares = |points: Vec<[f64; 2]>, shares: Vec<f64>| {
            let total: f64 = shares.iter().sum();
            Quadrature { points, weights: shares.into_iter().map(|w| w / total).collect() }
        };
        match self {
            Self::Footprint => shape.quadrature(count),
            Self::Scaled(scale) => {
                positive("scale of the bearing", *scale)?;
                let mut rule = shape.quadrature(count)?;
                rule.points.iter_mut().flatten().for_each(|x| *x *= scale);
                Ok(rule)
            }
            Self::Ring(scale) => {
                positive("scale of the bearing", *scale)?;
                shape.validate()?;
                let mut points = shape.rim(count.max(8));
                points.iter_mut().flatten().for_each(|x| *x *= scale);
                let n = points.len();
                let side = |i: usize| {
                    let (p, q) = (points[i % n], points[(i + 1) % n]);
                    (q[0] - p[0]).hypot(q[1] - p[1])
                };
                // Half of the rim on either side belongs to a point.
                let lengths = (0..n).map(|i| side(i + n - 1) + side(i)).collect();
                Ok(shares(points, lengths))
            }
            Self::Feet(points) => Ok(shares(points.clone(), vec![1.0; points.len()])),
            Self::Map(points) => {
                points.iter().try_for_each(|p| positive("weight of a point of the bearing", p[2]))?;
                Ok(shares(points.iter().map(|p| [p[0], p[1]]).collect(), points.iter().map(|p| p[2]).collect()))
            }
        }
    }

    /// The convex hull as a shape with its center and scale; absent for lists of points without area.
    fn hull(&self, shape: &Shape, points: &[[f64; 2]]) -> Result<(Shape, f64, [f64; 2]), PlateError> {
        match self {
            Self::Footprint => Ok((shape.clone(), 1.0, [0.0; 2])),
            Self::Scaled(scale) | Self::Ring(scale) => Ok((shape.clone(), *scale, [0.0; 2])),
            Self::Feet(_) | Self::Map(_) => {
                let corners = convex_hull(points);
                let hull = Shape::polygon(&corners)?;
                let Shape::Polygon { vertices } = &hull else { return Ok((hull, 1.0, [0.0; 2])) };
                // The corners are in order, so that they stay in it; the polygon has moved to its centroid.
                let center = [0, 1].map(|i| corners[0][i] - vertices[0][i]);
                Ok((hull, 1.0, center))
            }
        }
    }
}

/// The corners of the convex hull, counter-clockwise (Andrew 1979).
fn convex_hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|p, q| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])));
    let chain = |points: &mut dyn Iterator<Item = &[f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..]
                && (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) <= 0.0
            {
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut sorted.iter());
    hull.extend(chain(&mut sorted.iter().rev()));
    hull
}

/// The contact of an object with the plate, about its center of mass.
///
/// The pressure that carries a load `N` with the moments `M = ∫ r p` (per mass, own axes) is affine on the patch,
///
/// ```text
/// p(r) = N + (M − N r̄)ᵀ C⁻¹ (r − r̄)
/// ```
///
/// with the mean point `r̄` of the patch and its second moments `C` about it. On a whole footprint about the center of mass,
/// `r̄ = 0` and `C` is the matrix of the second moments of the mass.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    /// Points from the center of mass, in m, with their shares.
    pub(crate) rule: Quadrature,
    /// The mean point `r̄` from the center of mass, in m.
    pub(crate) mean: [f64; 2],
    /// `C⁻¹`: xx, xy, yy, in 1/m².
    pub(crate) inverse: [f64; 3],
    /// Root of the trace of `C`, in m.
    pub(crate) size: f64,
    /// Whether the patch is distributed as the mass: `C = S`.
    as_mass: bool,
    /// The hull: a shape with its scale, and its center from the center of mass.
    pub(crate) hull: Shape,
    pub(crate) scale: f64,
    pub(crate) center: [f64; 2],
}

impl Patch {
    pub(crate) fn of(object: &Object, points: usize) -> Result<Self, PlateError> {
        object.validate()?;
        let mut rule = object.bearing.rule(&object.shape, points)?;
        let (hull, scale, mut center) = object.bearing.hull(&object.shape, &rule.points)?;
        let as_mass = object.bearing == Bearing::Footprint;
        let from = object.center_of_mass;
        let (mut mean, (xx, yy, xy)) =
            if as_mass { ([0.0; 2], object.shape.second_moments_at(0.0)) } else { moments(&rule) };
        if from != [0.0; 2] {
            let shift = |p: &mut [f64; 2]| *p = [p[0] - from[0], p[1] - from[1]];
            rule.points.iter_mut().for_each(shift);
            shift(&mut center);
            shift(&mut mean);
        }
        let determinant = xx * yy - xy * xy;
        if determinant.is_nan() || determinant <= 1e-9 * xx * yy {
            return Err(PlateError::BadNumber { name: "second moments of the bearing", value: determinant });
        }
        let inverse = [yy / determinant, -xy / determinant, xx / determinant];
        Ok(Self { rule, mean, inverse, size: (xx + yy).sqrt(), as_mass, hull, scale, center })
    }

    /// Slope of the pressure over the mean for a center of pressure `at` from the center of mass: `C⁻¹ (at − r̄)`.
    pub(crate) fn slope(&self, at: [f64; 2]) -> [f64; 2] {
        let [ixx, ixy, iyy] = self.inverse;
        let at = [at[0] - self.mean[0], at[1] - self.mean[1]];
        [ixx * at[0] + ixy * at[1], ixy * at[0] + iyy * at[1]]
    }

    /// Pressure over the mean at the center of mass.
    pub(crate) fn middle(&self, slope: [f64; 2]) -> f64 {
        1.0 - (slope[0] * self.mean[0] + slope[1] * self.mean[1])
    }

    /// The point of the hull farthest along a direction, from the center of mass.
    pub(crate) fn farthest(&self, direction: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.hull.support(direction);
        [self.center[0] + self.scale * x, self.center[1] + self.scale * y]
    }

    /// Share of the way from the middle of the hull to its rim at which a point lies; see [`Shape::rim_share`].
    pub(crate) fn rim_share(&self, point: [f64; 2]) -> f64 {
        self.hull.rim_share([0, 1].map(|i| (point[i] - self.center[i]) / self.scale))
    }

    /// The pressure at a point under inertia: with the moments `M = S q` of the mass, `p = N α + q · β`. Gives `α` and `β` (m).
    pub(crate) fn response(&self, object: &Object, point: [f64; 2]) -> (f64, [f64; 2]) {
        let r = [point[0] - self.mean[0], point[1] - self.mean[1]];
        let [ixx, ixy, iyy] = self.inverse;
        let along = [ixx * r[0] + ixy * r[1], ixy * r[0] + iyy * r[1]];
        let level = 1.0 - (self.mean[0] * along[0] + self.mean[1] * along[1]);
        if self.as_mass {
            return (level, r);
        }
        let (sxx, syy, sxy) = object.shape.second_moments_at(0.0);
        (level, [sxx * along[0] + sxy * along[1], sxy * along[0] + syy * along[1]])
    }
}

/// Mean point and second moments `xx, yy, xy` about it.
fn moments(rule: &Quadrature) -> ([f64; 2], (f64, f64, f64)) {
    let sum = |f: &dyn Fn(&[f64; 2]) -> f64| rule.points.iter().zip(&rule.weights).map(|(p, w)| w * f(p)).sum::<f64>();
    let mean = [sum(&|p| p[0]), sum(&|p| p[1])];
    let second = |i: usize, j: usize| sum(&|p| (p[i] - mean[i]) * (p[j] - mean[j]));
    (mean, (second(0, 0), second(1, 1), second(0, 1)))
}
