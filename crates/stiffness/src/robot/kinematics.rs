//! Where all frames are, and how they move with the joints.

use super::chain::{JointKind, Robot};
use super::frame::{Twist, Wrench, stacked, wrench_in};
use crate::error::StiffnessError;
use nalgebra::{Isometry3, Matrix6xX, Vector3};

/// Frames and geometric Jacobian of a robot in one pose. Renewed by [`Kinematics::update`] without allocation.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinematics {
    frames: Vec<Isometry3<f64>>,
    axes: Vec<Vector3<f64>>,
    tool: Isometry3<f64>,
    jacobian: Matrix6xX<f64>,
}

impl Kinematics {
    /// The robot at coordinates `q`.
    ///
    /// # Errors
    /// [`StiffnessError`] for a wrong number of coordinates or one that is not finite.
    pub fn new(robot: &Robot, q: &[f64]) -> Result<Self, StiffnessError> {
        let joints = robot.joints.len();
        let mut kinematics = Self {
            frames: vec![Isometry3::identity(); joints],
            axes: vec![Vector3::zeros(); joints],
            tool: Isometry3::identity(),
            jacobian: Matrix6xX::zeros(joints),
        };
        kinematics.update(robot, q)?;
        Ok(kinematics)
    }

    /// The same robot at other coordinates.
    ///
    /// # Errors
    /// As [`Kinematics::new`]; also for a robot with another number of joints.
    pub fn update(&mut self, robot: &Robot, q: &[f64]) -> Result<(), StiffnessError> {
        robot.check("coordinates", q)?;
        if self.frames.len() != q.len() {
            return Err(StiffnessError::Count { what: "frames", found: self.frames.len(), joints: q.len() });
        }
        let mut pose = Isometry3::identity();
        for (i, joint) in robot.joints.iter().enumerate() {
            pose *= joint.placement * joint.motion(q[i]);
            self.frames[i] = pose;
            self.axes[i] = pose.rotation * joint.axis.into_inner();
        }
        self.tool = pose * robot.tool;
        let point = self.tool.translation.vector;
        for (i, joint) in robot.joints.iter().enumerate() {
            let column = column(joint.kind, &self.axes[i], &(point - self.frames[i].translation.vector));
            self.jacobian.column_mut(i).copy_from(&column);
        }
        Ok(())
    }

    /// Frames of the joints in the base, from the base on; they have moved with their joint.
    pub fn frames(&self) -> &[Isometry3<f64>] {
        &self.frames
    }

    /// Axes of the joints in base axes.
    pub fn axes(&self) -> &[Vector3<f64>] {
        &self.axes
    }

    /// Frame of the tool point in the base.
    pub fn tool(&self) -> &Isometry3<f64> {
        &self.tool
    }

    /// Geometric Jacobian, 6 × joints: twist of the tool point in base axes per joint rate.
    pub fn jacobian(&self) -> &Matrix6xX<f64> {
        &self.jacobian
    }

    /// Torque (N·m; N where it slides) that a wrench at the tool point, in base axes, exerts on a joint.
    pub fn torque(&self, joint: usize, wrench: &Wrench) -> f64 {
        self.jacobian.column(joint).dot(wrench)
    }

    /// What a wrench at the tool point, in base axes, is at the frame of a joint, in its axes.
    pub fn wrench_at(&self, joint: usize, wrench: &Wrench) -> Wrench {
        wrench_in(&self.frames[joint], &self.tool.translation.vector, wrench)
    }

    /// Pose of the frame of a joint seen from the tool point, in base axes: what carries a twist there to the tool point.
    pub(crate) fn to_tool(&self, joint: usize) -> Isometry3<f64> {
        let frame = &self.frames[joint];
        let arm = frame.translation.vector - self.tool.translation.vector;
        Isometry3::from_parts(arm.into(), frame.rotation)
    }

    /// Derivative of the Jacobian along a joint: `∂(column i)/∂q_j`.
    pub fn jacobian_derivative(&self, robot: &Robot, i: usize, j: usize) -> Twist {
        let (joint_i, joint_j) = (robot.joints[i].kind, robot.joints[j].kind);
        let point = self.tool.translation.vector;
        let (zi, zj) = (self.axes[i], self.axes[j]);
        let arm = point - self.frames[i].translation.vector;
        // What lies behind joint j turns about its axis; a sliding joint turns nothing.
        let turns = joint_j == JointKind::Revolute;
        let (axis_moves, arm_moves) = match (j <= i, turns) {
            (true, true) => (zj.cross(&zi), zj.cross(&arm)),
            (true, false) => return Twist::zeros(),
            (false, true) => (Vector3::zeros(), zj.cross(&(point - self.frames[j].translation.vector))),
            (false, false) => (Vector3::zeros(), zj),
        };
        match joint_i {
            JointKind::Revolute => stacked(&(axis_moves.cross(&arm) + zi.cross(&arm_moves)), &axis_moves),
            JointKind::Prismatic => stacked(&axis_moves, &Vector3::zeros()),
        }
    }
}

/// A column of the Jacobian for an axis and the arm from the joint to the point.
fn column(kind: JointKind, axis: &Vector3<f64>, arm: &Vector3<f64>) -> Twist {
    match kind {
        JointKind::Revolute => stacked(&axis.cross(arm), axis),
        JointKind::Prismatic => stacked(axis, &Vector3::zeros()),
    }
}
