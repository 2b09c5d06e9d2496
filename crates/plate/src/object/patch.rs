//! Where and how an object presses on the plate, about its center of mass.

use super::bearing::{Bearing, convex_hull};
use super::prism::Object;
use super::quadrature::Quadrature;
use super::shape::Shape;
use crate::PlateError;

/// Distance from the hull of the points, in sizes of the patch, below which a point inside counts as on it.
const INSIDE: f64 = 1e-9;

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
    /// The corners of the convex hull of the points, counter-clockwise, from the center of mass, in m.
    corners: Vec<[f64; 2]>,
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
        let corners = convex_hull(&rule.points);
        Ok(Self { rule, mean, inverse, size: (xx + yy).sqrt(), as_mass, hull, scale, center, corners })
    }

    /// Whether a point from the center of mass lies inside the hull of the points, by more than rounding.
    pub(crate) fn is_inside(&self, at: [f64; 2]) -> bool {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).all(|(p, q)| {
            let (along, to) = ([q[0] - p[0], q[1] - p[1]], [at[0] - p[0], at[1] - p[1]]);
            along[0] * to[1] - along[1] * to[0] > INSIDE * self.size * along[0].hypot(along[1])
        })
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
