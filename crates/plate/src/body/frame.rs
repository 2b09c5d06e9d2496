//! Frames: the body, the plate and the world.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::PlateKinematics;

/// Place and velocity of a rigid body, seen from one frame and in the axes of that frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidState {
    /// Position of the center of mass in m.
    pub position: Vector3<f64>,
    /// Rotation from the axes of the body to the axes of the frame.
    pub orientation: UnitQuaternion<f64>,
    /// Velocity of the center of mass relative to the frame in m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity relative to the frame in rad/s.
    pub angular_velocity: Vector3<f64>,
}

impl RigidState {
    /// At rest, the center of mass at the height `height` above the origin.
    pub fn at_rest(height: f64) -> Self {
        Self {
            position: Vector3::new(0.0, 0.0, height),
            orientation: UnitQuaternion::identity(),
            velocity: Vector3::zeros(),
            angular_velocity: Vector3::zeros(),
        }
    }

    /// Position and orientation.
    pub fn pose(&self) -> Isometry3<f64> {
        Isometry3::from_parts(self.position.into(), self.orientation)
    }

    /// Moved by `shift` and rotated by the rotation vector `rotation`, velocities unchanged.
    pub(super) fn displaced(&self, shift: &Vector3<f64>, rotation: &Vector3<f64>) -> Self {
        let mut orientation = UnitQuaternion::from_scaled_axis(*rotation) * self.orientation;
        orientation.renormalize();
        Self { position: self.position + shift, orientation, ..*self }
    }

    /// All 13 numbers.
    pub(super) fn components(&self) -> impl Iterator<Item = f64> {
        let vectors = self.position.iter().chain(self.velocity.iter()).chain(self.angular_velocity.iter());
        vectors.chain(self.orientation.coords.iter()).copied()
    }
}

/// The frame fixed to the plate at one instant: origin `(X, 0, 0)`, axes rotated by `θ` about the world's x axis.
#[derive(Debug, Clone, Copy)]
pub struct PlateFrame {
    origin: Vector3<f64>,
    origin_velocity: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    rate: Vector3<f64>,
}

impl PlateFrame {
    /// The frame of a plate that moves so.
    pub fn new(plate: &PlateKinematics) -> Self {
        Self {
            origin: Vector3::x() * plate.displacement,
            origin_velocity: Vector3::x() * plate.velocity,
            rotation: UnitQuaternion::from_axis_angle(&Vector3::x_axis(), plate.tilt),
            rate: Vector3::x() * plate.tilt_rate,
        }
    }

    /// The pose of the plate in the world.
    pub fn pose(&self) -> Isometry3<f64> {
        Isometry3::from_parts(self.origin.into(), self.rotation)
    }

    /// From the plate frame to the world: `r = O + R p`, `r' = O' + R (p' + Ω × p)`, `ω = R (ω_rel + Ω)`.
    pub fn to_world(&self, relative: &RigidState) -> RigidState {
        let p = &relative.position;
        RigidState {
            position: self.origin + self.rotation * p,
            orientation: self.rotation * relative.orientation,
            velocity: self.origin_velocity + self.rotation * (relative.velocity + self.rate.cross(p)),
            angular_velocity: self.rotation * (relative.angular_velocity + self.rate),
        }
    }

    /// From the world to the plate frame; the inverse of [`to_world`](Self::to_world).
    pub fn from_world(&self, absolute: &RigidState) -> RigidState {
        let back = self.rotation.inverse();
        let position = back * (absolute.position - self.origin);
        RigidState {
            position,
            orientation: back * absolute.orientation,
            velocity: back * (absolute.velocity - self.origin_velocity) - self.rate.cross(&position),
            angular_velocity: back * absolute.angular_velocity - self.rate,
        }
    }
}
