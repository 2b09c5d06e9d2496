//! Compliance at the tool point of a robot that carries a load.

use super::spring::Springs;
use crate::error::StiffnessError;
use crate::robot::{Kinematics, Robot, Wrench, check_wrench, twist_adjoint};
use nalgebra::{DMatrix, Matrix6};

/// `K_g = ∂(Jᵀ W)/∂q` for a wrench in base axes that goes with the tool point: what the load does as its lever changes
/// (Chen and Kao 2000, conservative congruence transformation), joints × joints.
///
/// It is symmetric for a force alone; a moment that keeps its axes is not conservative.
///
/// # Errors
/// [`StiffnessError`] for a wrench that is not finite.
pub fn geometric_stiffness(
    robot: &Robot,
    kinematics: &Kinematics,
    wrench: &Wrench,
) -> Result<DMatrix<f64>, StiffnessError> {
    check_wrench(wrench)?;
    let n = robot.joints.len();
    Ok(DMatrix::from_fn(n, n, |i, j| kinematics.jacobian_derivative(robot, i, j).dot(wrench)))
}

/// Compliance at the tool point in base axes, `C = J (K_θ − K_g)⁻¹ Jᵀ`, with the tangent stiffness `K_θ` of the joints' springs at the
/// torques of `wrench` and its [`geometric_stiffness`]; links as they yield at this pose, without what the load does to their levers. With no
/// wrench, the plain `J K_θ⁻¹ Jᵀ`.
///
/// # Errors
/// [`StiffnessError::Unstable`] where the load overcomes the springs; [`StiffnessError`] for springs or a wrench that do not fit.
pub fn loaded_compliance(
    robot: &Robot,
    springs: &Springs,
    kinematics: &Kinematics,
    wrench: &Wrench,
) -> Result<Matrix6<f64>, StiffnessError> {
    springs.check(robot.joints.len())?;
    let mut stiffness = -geometric_stiffness(robot, kinematics, wrench)?;
    for (i, spring) in springs.joints.iter().enumerate() {
        stiffness[(i, i)] += 1.0 / spring.compliance(kinematics.torque(i, wrench));
    }
    let symmetric = 0.5 * (&stiffness + stiffness.transpose());
    let smallest = symmetric.symmetric_eigenvalues().min();
    if smallest <= 0.0 {
        return Err(StiffnessError::Unstable { smallest });
    }
    let jacobian = kinematics.jacobian();
    let yields = stiffness.lu().solve(&jacobian.transpose()).ok_or(StiffnessError::Unstable { smallest })?;
    let product = jacobian * yields;
    let mut compliance: Matrix6<f64> = product.fixed_view::<6, 6>(0, 0).into();
    for (i, link) in springs.links.iter().enumerate() {
        let to_tool = twist_adjoint(&kinematics.to_tool(i));
        compliance += to_tool * link * to_tool.transpose();
    }
    Ok(compliance)
}
