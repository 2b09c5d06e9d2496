//! A serial robot: joints, each with its place behind the last one, and a tool.

use crate::error::{StiffnessError, check_entries};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};

/// What a joint does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis; its coordinate is in rad.
    Revolute,
    /// Slides along its axis; its coordinate is in m.
    Prismatic,
}

/// A joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// What it does.
    pub kind: JointKind,
    /// Pose of its frame in the frame of the joint before, at coordinate 0 less the offset.
    pub placement: Isometry3<f64>,
    /// Its axis, in its own frame.
    pub axis: Unit<Vector3<f64>>,
    /// Added to its coordinate (rad or m).
    pub offset: f64,
}

impl Joint {
    /// The motion of its frame at coordinate `q`.
    pub fn motion(&self, q: f64) -> Isometry3<f64> {
        let q = q + self.offset;
        match self.kind {
            JointKind::Revolute => {
                Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&self.axis, q))
            }
            JointKind::Prismatic => {
                Isometry3::from_parts(Translation3::from(self.axis.into_inner() * q), UnitQuaternion::identity())
            }
        }
    }
}

/// A row of Denavit–Hartenberg parameters of a revolute joint: lengths in m, angles in rad.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DhParameters {
    /// Twist angle α.
    pub alpha: f64,
    /// Length a.
    pub a: f64,
    /// Offset d along the axis.
    pub d: f64,
    /// Added to the joint's angle θ.
    pub offset: f64,
}

impl DhParameters {
    /// `Rot_x(α) Trans_x(a)`.
    fn link(&self) -> Isometry3<f64> {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), self.alpha);
        Isometry3::from_parts(Translation3::new(self.a, 0.0, 0.0), turn)
    }

    /// `Trans_z(d)`.
    fn along(&self) -> Isometry3<f64> {
        Isometry3::translation(0.0, 0.0, self.d)
    }

    fn joint(&self, number: usize, placement: Isometry3<f64>) -> Joint {
        Joint {
            name: format!("joint_{number}"),
            kind: JointKind::Revolute,
            placement,
            axis: Vector3::z_axis(),
            offset: self.offset,
        }
    }
}

/// A serial robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// Its joints from the base on.
    pub joints: Vec<Joint>,
    /// Pose of the tool point's frame in the frame of the last joint.
    pub tool: Isometry3<f64>,
}

impl Robot {
    /// A robot from modified parameters (Craig 2005): the transform of a joint is
    /// `Rot_x(α) Trans_x(a) Rot_z(θ + offset) Trans_z(d)`.
    pub fn from_modified_dh(name: impl Into<String>, rows: &[DhParameters]) -> Self {
        let joints = rows.iter().enumerate().map(|(i, row)| row.joint(i + 1, row.link() * row.along())).collect();
        Self { name: name.into(), joints, tool: Isometry3::identity() }
    }

    /// A robot from standard parameters (Denavit and Hartenberg 1955): the transform of a joint is
    /// `Rot_z(θ + offset) Trans_z(d) Trans_x(a) Rot_x(α)`. The frame of a joint here is the one that turns with it before its link.
    pub fn from_standard_dh(name: impl Into<String>, rows: &[DhParameters]) -> Self {
        let mut placement = Isometry3::identity();
        let mut joints = Vec::with_capacity(rows.len());
        for (i, row) in rows.iter().enumerate() {
            joints.push(row.joint(i + 1, placement));
            placement = row.along() * row.link();
        }
        Self { name: name.into(), joints, tool: placement }
    }

    /// The robot with a tool: `pose` of its point in the frame that ended the robot so far.
    #[must_use]
    pub fn with_tool(mut self, pose: Isometry3<f64>) -> Self {
        self.tool *= pose;
        self
    }

    /// Pose of the tool point in the base at coordinates `q`.
    ///
    /// # Errors
    /// [`StiffnessError`] for a wrong number of coordinates or one that is not finite.
    pub fn tool_pose(&self, q: &[f64]) -> Result<Isometry3<f64>, StiffnessError> {
        self.check("coordinates", q)?;
        let moved = self.joints.iter().zip(q).map(|(joint, q)| joint.placement * joint.motion(*q));
        Ok(moved.fold(Isometry3::identity(), |pose, next| pose * next) * self.tool)
    }

    /// One finite number for each joint.
    pub(crate) fn check(&self, what: &'static str, values: &[f64]) -> Result<(), StiffnessError> {
        if values.len() != self.joints.len() {
            return Err(StiffnessError::Count { what, found: values.len(), joints: self.joints.len() });
        }
        check_entries(what, values)
    }
}
