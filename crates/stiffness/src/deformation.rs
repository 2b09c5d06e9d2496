//! What a load does to a robot, frame by frame.

use crate::error::StiffnessError;
use crate::frame::{Twist, Wrench, displaced, displacement_between, twist_adjoint, wrench_in};
use crate::robot::{JointKind, Robot, check_wrench};
use crate::spring::Springs;
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
        check(robot, springs, q, wrench)?;
        let mut yielded = Yielded::none(q.len());
        let unloaded = Bent::new(robot, q, &yielded.locals);
        unloaded.yield_to(robot, springs, wrench, &mut yielded);
        // Twists at the origin of the base add up.
        let mut total = Twist::zeros();
        let mut frames = Vec::with_capacity(q.len());
        for (frame, local) in unloaded.springs.iter().zip(&yielded.locals) {
            total += twist_adjoint(frame) * local;
            frames.push(at_point(&total, &frame.translation.vector));
        }
        let tool = at_point(&total, &unloaded.tool.translation.vector);
        Ok(Self { deflections: yielded.deflections, frames, tool })
    }

    /// The product of deformed transforms: every joint turned by its deflection and every link displaced, under the wrenches of the
    /// unloaded pose, transported to each undeformed frame.
    ///
    /// # Errors
    /// As [`Deformation::linear`].
    pub fn product(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench) -> Result<Self, StiffnessError> {
        check(robot, springs, q, wrench)?;
        let mut yielded = Yielded::none(q.len());
        let unloaded = Bent::new(robot, q, &yielded.locals);
        unloaded.yield_to(robot, springs, wrench, &mut yielded);
        let bent = Bent::new(robot, q, &yielded.locals);
        Ok(unloaded.moved_to(&bent, yielded.deflections))
    }

    /// The loaded equilibrium: the wrench keeps its axes and acts on the tool point where it has moved to.
    ///
    /// # Errors
    /// As [`Deformation::linear`]; [`StiffnessError::NoEquilibrium`] where the iteration does not settle.
    pub fn equilibrium(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench) -> Result<Self, StiffnessError> {
        check(robot, springs, q, wrench)?;
        let mut yielded = Yielded::none(q.len());
        let unloaded = Bent::new(robot, q, &yielded.locals);
        let mut bent = unloaded.clone();
        let mut change = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            change = bent.yield_to(robot, springs, wrench, &mut yielded);
            bent.update(robot, q, &yielded.locals);
            if change <= SETTLED {
                return Ok(unloaded.moved_to(&bent, yielded.deflections));
            }
        }
        Err(StiffnessError::NoEquilibrium { iterations: MOST_ITERATIONS, change })
    }
}

/// The frames of a robot whose springs have yielded. Renewed by [`Bent::update`] without allocation.
#[derive(Clone, Debug)]
pub(crate) struct Bent {
    /// Frame of each joint as its springs find it.
    springs: Vec<Isometry3<f64>>,
    /// The same after they have yielded.
    frames: Vec<Isometry3<f64>>,
    pub(crate) tool: Isometry3<f64>,
}

/// What springs do under a load.
#[derive(Clone, Debug)]
pub(crate) struct Yielded {
    pub(crate) deflections: Vec<f64>,
    /// Displacement of each joint's frame in its own axes.
    pub(crate) locals: Vec<Twist>,
}

impl Yielded {
    /// No load.
    pub(crate) fn none(joints: usize) -> Self {
        Self { deflections: vec![0.0; joints], locals: vec![Twist::zeros(); joints] }
    }
}

impl Bent {
    pub(crate) fn new(robot: &Robot, q: &[f64], locals: &[Twist]) -> Self {
        let none = vec![Isometry3::identity(); q.len()];
        let mut bent = Self { springs: none.clone(), frames: none, tool: Isometry3::identity() };
        bent.update(robot, q, locals);
        bent
    }

    pub(crate) fn update(&mut self, robot: &Robot, q: &[f64], locals: &[Twist]) {
        let mut pose = Isometry3::identity();
        for (i, joint) in robot.joints.iter().enumerate() {
            pose *= joint.placement * joint.motion(q[i]);
            self.springs[i] = pose;
            pose *= displaced(&Isometry3::identity(), &locals[i]);
            self.frames[i] = pose;
        }
        self.tool = pose * robot.tool;
    }

    /// What the springs do at these frames; gives the largest change against what `yielded` held.
    pub(crate) fn yield_to(&self, robot: &Robot, springs: &Springs, wrench: &Wrench, yielded: &mut Yielded) -> f64 {
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
            change = change.max((local - yielded.locals[i]).amax());
            yielded.deflections[i] = deflection;
            yielded.locals[i] = local;
        }
        change
    }

    fn moved_to(&self, bent: &Bent, deflections: Vec<f64>) -> Deformation {
        let frames = self.frames.iter().zip(&bent.frames);
        Deformation {
            deflections,
            frames: frames.map(|(from, to)| displacement_between(from, to)).collect(),
            tool: displacement_between(&self.tool, &bent.tool),
        }
    }
}

/// A twist at the origin of the base, seen at a point.
fn at_point(twist: &Twist, point: &Vector3<f64>) -> Twist {
    let rotation: Vector3<f64> = twist.fixed_rows::<3>(3).into();
    let mut moved = *twist;
    let mut translation = moved.fixed_rows_mut::<3>(0);
    translation += rotation.cross(point);
    moved
}

fn check(robot: &Robot, springs: &Springs, q: &[f64], wrench: &Wrench) -> Result<(), StiffnessError> {
    robot.check("coordinates", q)?;
    springs.check(robot.joints.len())?;
    check_wrench(wrench)
}
