//! The numbers of joint springs as a list of logarithms.

use super::error::IdentificationError;
use crate::deformation::Deformation;
use crate::error::StiffnessError;
use crate::frame::{Twist, Wrench};
use crate::robot::Robot;
use crate::spring::{JointSpring, Springs};
use nalgebra::DVector;

/// Which prediction of the displacement the springs are fitted with.
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
    pub(super) fn displacement(
        self,
        robot: &Robot,
        springs: &Springs,
        q: &[f64],
        wrench: &Wrench,
    ) -> Result<Twist, StiffnessError> {
        let deformation = match self {
            Self::Linear => Deformation::linear(robot, springs, q, wrench),
            Self::Product => Deformation::product(robot, springs, q, wrench),
            Self::Equilibrium => Deformation::equilibrium(robot, springs, q, wrench),
        };
        Ok(deformation?.tool)
    }
}

/// A number of a joint's spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Parameter {
    /// From 0.
    pub(super) joint: usize,
    pub(super) name: &'static str,
    pub(super) value: f64,
}

/// All parameters, joint by joint, the stiffness first. Refuses those whose logarithm cannot be taken, and a robot without joints.
pub(super) fn parameters(springs: &Springs) -> Result<Vec<Parameter>, IdentificationError> {
    let mut list = Vec::new();
    for (joint, spring) in springs.joints.iter().enumerate() {
        let numbers = match *spring {
            JointSpring::Linear { stiffness } => vec![("stiffness", stiffness)],
            JointSpring::Stiffening { stiffness, cubic } => vec![("stiffness", stiffness), ("cubic", cubic)],
            JointSpring::Backlash { stiffness, gap, engaged } => {
                vec![("stiffness", stiffness), ("gap", gap), ("engaged", engaged)]
            }
        };
        for (name, value) in numbers {
            if value <= 0.0 {
                return Err(IdentificationError::Start { joint: joint + 1, name, value });
            }
            list.push(Parameter { joint, name, value });
        }
    }
    if list.is_empty() {
        return Err(IdentificationError::NotIdentified { parameters: vec!["the robot has no joints".to_owned()] });
    }
    Ok(list)
}

pub(super) fn logarithms(parameters: &[Parameter]) -> DVector<f64> {
    DVector::from_iterator(parameters.len(), parameters.iter().map(|p| p.value.ln()))
}

/// Springs of the same kinds with other parameters.
pub(super) fn springs_at(start: &Springs, logarithms: &DVector<f64>) -> Springs {
    let mut values = logarithms.iter().map(|v| v.exp());
    let mut springs = start.clone();
    for spring in &mut springs.joints {
        let numbers = match spring {
            JointSpring::Linear { stiffness } => vec![stiffness],
            JointSpring::Stiffening { stiffness, cubic } => vec![stiffness, cubic],
            JointSpring::Backlash { stiffness, gap, engaged } => vec![stiffness, gap, engaged],
        };
        numbers.into_iter().zip(&mut values).for_each(|(number, value)| *number = value);
    }
    springs
}

/// Stiffness of joints that count as rigid, where links alone are asked for (N·m/rad).
const RIGID: f64 = 1e30;

/// First-order displacement of the tool point by the compliances of the links alone.
pub(super) fn links_alone(
    robot: &Robot,
    springs: &Springs,
    q: &[f64],
    wrench: &Wrench,
) -> Result<Twist, StiffnessError> {
    if springs.links.is_empty() {
        return Ok(Twist::zeros());
    }
    let rigid = Springs::linear(&vec![RIGID; springs.joints.len()]).with_links(springs.links.clone());
    Ok(Deformation::linear(robot, &rigid, q, wrench)?.tool)
}
