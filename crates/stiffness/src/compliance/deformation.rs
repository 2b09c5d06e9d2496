//! What a load does to a robot, frame by frame.

use super::spring::Springs;
use crate::error::StiffnessError;
use crate::robot::{
    JointKind, Robot, Twist, Wrench, check_wrench, displaced, displacement_between, halves, stacked, twist_adjoint,
    wrench_in,
};
use nalgebra::{Isometry3, Vector3};

/// Most iterations to the loaded equilibrium.
const MOST_ITERATIONS: usize = 50;
/// Change of a frame (m, rad) below which the equilibrium is found.
const SETTLED: f64 = 1e-14;

/// Where a load moves the frames of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Deformation {
    /// Deflection of every joint (rad; m where it slides).
    pub deflections: Vec<f64>,
    /// Displacement of every joint's frame with the link behind it, at its origin, in base axes: ΔP (m), ΔR (rotation vector, rad).
    pub frames: Vec<Twist>,
    /// Displacement of the tool point, in base axes: ΔP (m), ΔR (rotation vector, rad).
    pub tool: Twist,
}

impl Deformation {
    /// First order: springs under the wrenches of the unloaded pose, small displacements added up at every frame. At the tool
    /// point of a robot with linear springs this is `C W`.
    ///
    /// `wrench` acts on the tool point, in base axes.
    ///
    /// # Errors
    /// [`StiffnessError`] for coordinates, springs or a wrench that do not fit.
    pub fn linear(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench) -> Result<Self, StiffnessError> {
        let (unloaded, deflected) = first_order(robot, springs, q, wrench)?;
        // Twists at the origin of the base add up.
        let mut total = Twist::zeros();
        let mut frames = Vec::with_capacity(q.len());
        for (frame, local) in unloaded.springs.iter().zip(&deflected.locals) {
            total += twist_adjoint(frame) * local;
            frames.push(twist_at(&frame.translation.vector, &total));
        }
        let tool = twist_at(&unloaded.tool.translation.vector, &total);
        Ok(Self { deflections: deflected.deflections, frames, tool })
    }

    /// The product of deformed transforms: every joint rotated by its deflection and every link displaced, under the wrenches of the
    /// unloaded pose, transported to each undeformed frame.
    ///
    /// # Errors
    /// As [`Deformation::linear`].
    pub fn product(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench) -> Result<Self, StiffnessError> {
        let (unloaded, deflected) = first_order(robot, springs, q, wrench)?;
        let deformed = DeformedFrames::new(robot, q, &deflected);
        Ok(unloaded.deformation_to(&deformed, deflected))
    }

    /// The loaded equilibrium: the wrench keeps its axes and acts on the tool point where it has moved to.
    ///
    /// # Errors
    /// As [`Deformation::linear`]; [`StiffnessError::NoEquilibrium`] where the iteration does not settle.
    pub fn equilibrium(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench) -> Result<Self, StiffnessError> {
        check(robot, springs, q, wrench)?;
        let mut deflected = Deflections::none(q.len());
        let unloaded = DeformedFrames::new(robot, q, &deflected);
        let mut deformed = unloaded.clone();
        let mut change = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            change = deformed.deflect(robot, springs, wrench, &mut deflected);
            deformed.update(robot, q, &deflected);
            if change <= SETTLED {
                return Ok(unloaded.deformation_to(&deformed, deflected));
            }
        }
        Err(StiffnessError::NoEquilibrium { iterations: MOST_ITERATIONS, change })
    }
}

/// Which prediction of the displacement is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DeformationModel {
    /// [`Deformation::linear`].
    Linear,
    /// [`Deformation::product`].
    Product,
    /// [`Deformation::equilibrium`].
    #[default]
    Equilibrium,
}

impl DeformationModel {
    /// Displacement of the tool point under a wrench there, in base axes.
    pub(crate) fn displacement(
        self,
        robot: &Robot,
        springs: &Springs,
        q: &[f64],
        wrench: &Wrench,
    ) -> Result<Twist, StiffnessError> {
        let deformation = match self {
            Self::Linear => Deformation::linear,
            Self::Product => Deformation::product,
            Self::Equilibrium => Deformation::equilibrium,
        };
        Ok(deformation(robot, springs, q, wrench)?.tool)
    }
}

/// The frames of a robot with deflected springs. Renewed by [`DeformedFrames::update`] without allocation.
#[derive(Clone, Debug)]
pub(crate) struct DeformedFrames {
    /// Frame of each joint before its own springs deflect.
    springs: Vec<Isometry3<f64>>,
    /// The same after.
    frames: Vec<Isometry3<f64>>,
    pub(crate) tool: Isometry3<f64>,
}

/// Deflections of the springs under a load.
#[derive(Clone, Debug)]
pub(crate) struct Deflections {
    pub(crate) deflections: Vec<f64>,
    /// Displacement of each joint's frame in its own axes.
    pub(crate) locals: Vec<Twist>,
}

impl Deflections {
    /// No load.
    pub(crate) fn none(joints: usize) -> Self {
        Self { deflections: vec![0.0; joints], locals: vec![Twist::zeros(); joints] }
    }
}

impl DeformedFrames {
    pub(crate) fn new(robot: &Robot, q: &[f64], deflected: &Deflections) -> Self {
        let frames = vec![Isometry3::identity(); q.len()];
        let mut deformed = Self { springs: frames.clone(), frames, tool: Isometry3::identity() };
        deformed.update(robot, q, deflected);
        deformed
    }

    pub(crate) fn update(&mut self, robot: &Robot, q: &[f64], deflected: &Deflections) {
        let mut pose = Isometry3::identity();
        for (i, joint) in robot.joints.iter().enumerate() {
            pose *= joint.placement * joint.motion(q[i]);
            self.springs[i] = pose;
            pose *= displaced(&Isometry3::identity(), &deflected.locals[i]);
            self.frames[i] = pose;
        }
        self.tool = pose * robot.tool;
    }

    /// Deflections of the springs at these frames; returns the largest change against what `deflected` held.
    pub(crate) fn deflect(
        &self,
        robot: &Robot,
        springs: &Springs,
        wrench: &Wrench,
        deflected: &mut Deflections,
    ) -> f64 {
        let mut change: f64 = 0.0;
        for (i, (joint, frame)) in robot.joints.iter().zip(&self.springs).enumerate() {
            let here = wrench_in(frame, &self.tool.translation.vector, wrench);
            let rows = match joint.kind {
                JointKind::Prismatic => 0,
                JointKind::Revolute => 3,
            };
            let torque = here.fixed_rows::<3>(rows).dot(&joint.axis);
            let deflection = springs.joints[i].deflection(torque);
            let mut local = springs.links.get(i).map_or(Twist::zeros(), |link| link * here);
            let mut along = local.fixed_rows_mut::<3>(rows);
            along += joint.axis.into_inner() * deflection;
            change = change.max((local - deflected.locals[i]).amax());
            deflected.deflections[i] = deflection;
            deflected.locals[i] = local;
        }
        change
    }

    fn deformation_to(&self, deformed: &DeformedFrames, deflected: Deflections) -> Deformation {
        let frames = self.frames.iter().zip(&deformed.frames);
        Deformation {
            deflections: deflected.deflections,
            frames: frames.map(|(from, to)| displacement_between(from, to)).collect(),
            tool: displacement_between(&self.tool, &deformed.tool),
        }
    }
}

/// The unloaded frames, and the deflections of springs under the wrenches there.
fn first_order(
    robot: &Robot,
    springs: &Springs,
    q: &[f64],
    wrench: &Wrench,
) -> Result<(DeformedFrames, Deflections), StiffnessError> {
    check(robot, springs, q, wrench)?;
    let mut deflected = Deflections::none(q.len());
    let unloaded = DeformedFrames::new(robot, q, &deflected);
    unloaded.deflect(robot, springs, wrench, &mut deflected);
    Ok((unloaded, deflected))
}

/// A twist at the origin of the base, transported to a point.
fn twist_at(point: &Vector3<f64>, twist: &Twist) -> Twist {
    let (translation, rotation) = halves(twist);
    stacked(&(translation + rotation.cross(point)), &rotation)
}

fn check(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench) -> Result<(), StiffnessError> {
    robot.check("coordinates", q)?;
    springs.check(robot.joints.len())?;
    check_wrench(wrench)
}
