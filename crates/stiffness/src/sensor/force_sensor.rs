//! The force sensor between a robot and what it carries.

use nalgebra::Isometry3;

/// A force sensor between the robot and what it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceSensor {
    /// Pose of its frame (origin of its moments, its axes) in the frame of the tool point.
    pub pose: Isometry3<f64>,
    /// Largest force it can measure (N); beyond it a reading is a fault.
    pub force_range: f64,
    /// Largest moment it can measure (N·m).
    pub moment_range: f64,
}
