//! The solid: a straight prism over a convex outline, its inertia and the points where it can touch the plate.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::frame::RigidState;
use crate::object::Quadrature;
use crate::{Object, PlateError, Shape};

/// Points on the rim of a round face. The ring always has one of them at the lowest point of the rim.
const RING: usize = 24;

/// The rim of both faces.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Outline {
    /// Semi-axes.
    Ellipse { a: f64, b: f64 },
    /// Corners; those inside the convex hull touch only when the face lies flat.
    Corners(Vec<[f64; 2]>),
}

/// A straight prism of uniform density.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solid {
    outline: Outline,
    /// Points and weights of the footprint.
    rule: Quadrature,
    /// Half the thickness.
    half: f64,
    pub(super) mass: f64,
    /// Inertia about the center of mass, axes of the body.
    pub(super) inertia: Matrix3<f64>,
    pub(super) inverse_inertia: Matrix3<f64>,
    /// Largest distance of a point from the center of mass.
    pub(super) radius: f64,
}

impl Solid {
    /// The prism of an object, with about `points` points on each face.
    pub(super) fn of(object: &Object, points: usize) -> Result<Self, PlateError> {
        object.validate()?;
        object.stands_evenly()?;
        let outline = match &object.shape {
            Shape::Ellipse { a, b } => Outline::Ellipse { a: *a, b: *b },
            Shape::Disk { radius } => Outline::Ellipse { a: *radius, b: *radius },
            Shape::Rectangle { a, b } => Outline::Corners(vec![[*a, *b], [-a, *b], [-a, -b], [*a, -b]]),
            Shape::Polygon { vertices } => Outline::Corners(vertices.to_vec()),
        };
        let (sxx, syy, sxy) = object.shape.second_moments_at(0.0);
        let (half, mass) = (object.height, object.mass);
        let szz = object.normal_moment();
        let inertia = mass * Matrix3::new(syy + szz, -sxy, 0.0, -sxy, sxx + szz, 0.0, 0.0, 0.0, sxx + syy);
        let inverse_inertia = inertia.try_inverse().ok_or(PlateError::Inertia)?;
        let rim = match &outline {
            Outline::Ellipse { a, b } => a.max(*b),
            Outline::Corners(corners) => corners.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max),
        };
        let rule = object.shape.quadrature(points)?;
        Ok(Self { outline, rule, half, mass, inertia, inverse_inertia, radius: rim.hypot(half) })
    }

    /// The inertia in the axes of the frame in which the body has that orientation.
    pub(super) fn inertia_at(&self, orientation: &UnitQuaternion<f64>) -> Matrix3<f64> {
        let r = orientation.to_rotation_matrix();
        r.matrix() * self.inertia * r.matrix().transpose()
    }

    /// The points that can touch the plate, from the center of mass in the axes of the plate, into `points`: the rim of the
    /// face `z = -half`, then that of `z = +half` if it is another.
    ///
    /// Of a round rim they are [`RING`] points, the first of them the lowest. The numbers of the points keep their meaning
    /// from step to step: a rim that rolls keeps touching with its first.
    pub(super) fn points(&self, orientation: &UnitQuaternion<f64>, points: &mut Vec<Vector3<f64>>) {
        points.clear();
        let faces: &[f64] = if self.half > 0.0 { &[-1.0, 1.0] } else { &[-1.0] };
        let r = orientation.to_rotation_matrix();
        let down = -r.matrix().row(2);
        for face in faces {
            let z = face * self.half;
            match &self.outline {
                Outline::Ellipse { a, b } => {
                    // The support of an ellipse in direction d is (a² d_x, b² d_y)/|(a d_x, b d_y)|.
                    let start = (b * down[1]).atan2(a * down[0]);
                    for k in 0..RING {
                        let angle = start + std::f64::consts::TAU * k as f64 / RING as f64;
                        points.push(r * Vector3::new(a * angle.cos(), b * angle.sin(), z));
                    }
                }
                Outline::Corners(corners) => points.extend(corners.iter().map(|c| r * Vector3::new(c[0], c[1], z))),
            }
        }
    }

    /// The points of [`points`](Self::points) that can be the lowest ones: number, gap and its rate of change.
    pub(super) fn lowest_points(&self, state: &RigidState) -> Vec<(usize, f64, f64)> {
        let mut points = Vec::new();
        self.points(&state.orientation, &mut points);
        let stride = match &self.outline {
            Outline::Ellipse { .. } => RING,
            Outline::Corners(_) => 1,
        };
        let gap = |k: usize| {
            let arm = &points[k];
            (k, state.position.z + arm.z, state.velocity.z + state.angular_velocity.cross(arm).z)
        };
        (0..points.len()).step_by(stride).map(gap).collect()
    }

    /// The points inside a face, from the center of mass in the axes of the plate, with their shares of its area.
    pub(super) fn face_points(
        &self,
        orientation: &UnitQuaternion<f64>,
        upper: bool,
    ) -> impl Iterator<Item = (Vector3<f64>, f64)> {
        let r = orientation.to_rotation_matrix();
        let z = if upper { self.half } else { -self.half };
        self.rule.points.iter().zip(&self.rule.weights).map(move |(p, w)| (r * Vector3::new(p[0], p[1], z), *w))
    }

    /// How many points the rim of one face has.
    pub(super) fn points_per_face(&self) -> usize {
        match &self.outline {
            Outline::Ellipse { .. } => RING,
            Outline::Corners(corners) => corners.len(),
        }
    }

    /// The gap between the lowest point of the body and the plate, and its rate of change.
    pub(super) fn gap(&self, state: &RigidState) -> (f64, f64) {
        let r = state.orientation.to_rotation_matrix();
        let down = -r.matrix().row(2);
        let z = if down[2] > 0.0 { self.half } else { -self.half };
        let lowest = match &self.outline {
            Outline::Ellipse { a, b } => {
                let length = (a * down[0]).hypot(b * down[1]);
                if length > 0.0 {
                    Vector3::new(a * a * down[0] / length, b * b * down[1] / length, z)
                } else {
                    Vector3::new(0.0, 0.0, z)
                }
            }
            Outline::Corners(corners) => corners
                .iter()
                .map(|c| Vector3::new(c[0], c[1], z))
                .max_by(|p, q| (down * p).x.total_cmp(&(down * q).x))
                .unwrap_or_default(),
        };
        let arm = r * lowest;
        (state.position.z + arm.z, state.velocity.z + state.angular_velocity.cross(&arm).z)
    }
}
