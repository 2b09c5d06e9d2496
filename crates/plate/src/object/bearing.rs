//! Where an object presses on the plate, apart from where its mass is.

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
    pub(super) fn rule(&self, shape: &Shape, count: usize) -> Result<Quadrature, PlateError> {
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
    pub(super) fn hull(&self, shape: &Shape, points: &[[f64; 2]]) -> Result<(Shape, f64, [f64; 2]), PlateError> {
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
pub(super) fn convex_hull(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
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
