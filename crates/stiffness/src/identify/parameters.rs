//! The numbers of joint springs as a list of logarithms.

use super::error::IdentificationError;
use crate::compliance::{Deformation, Springs};
use crate::error::StiffnessError;
use crate::robot::{Robot, Twist, Wrench};
use nalgebra::DVector;

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
        for (name, value) in spring.parameters() {
            if value <= 0.0 {
                return Err(IdentificationError::Start { joint: joint + 1, name, value });
            }
            list.push(Parameter { joint, name, value });
        }
    }
    if list.is_empty() {
        return Err(IdentificationError::NoJoints);
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
        spring.parameters_mut().into_iter().zip(&mut values).for_each(|((_, parameter), value)| *parameter = value);
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
