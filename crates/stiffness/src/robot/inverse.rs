//! Joint coordinates for a pose of the tool point.

use super::chain::Robot;
use super::frame::{Twist, displacement_between, halves};
use super::kinematics::Kinematics;
use crate::error::StiffnessError;
use nalgebra::{Isometry3, Matrix6, Matrix6xX};

/// Most iterations to a pose.
const MOST_ITERATIONS: usize = 100;
/// Distance from a pose (m, rad) at which it is reached.
const REACHED: f64 = 1e-12;
/// Longest step of a joint in one iteration (rad, m).
const LONGEST_STEP: f64 = 0.3;
/// Damping of the steps (m, rad): what keeps them short where the robot is singular.
const DAMPING: f64 = 1e-4;

impl Robot {
    /// Joint coordinates that bring the tool point to `pose`, the solution near `start`: Newton's method with damped least
    /// squares (Wampler 1986), which takes the shortest step if there are more joints than needed.
    ///
    /// # Errors
    /// [`StiffnessError::NoPose`] where the iteration does not get there; [`StiffnessError`] for a start that does not fit.
    pub fn inverse(&self, pose: &Isometry3<f64>, start: &[f64]) -> Result<Vec<f64>, StiffnessError> {
        let mut q = start.to_vec();
        let mut kinematics = Kinematics::new(self, &q)?;
        let mut missing = displacement_between(kinematics.tool(), pose);
        for _ in 0..MOST_ITERATIONS {
            if missing.amax() <= REACHED {
                return Ok(q);
            }
            let weights = solve_damped(kinematics.jacobian(), &missing, DAMPING);
            let steps = kinematics.jacobian().transpose() * weights;
            let shorten = (LONGEST_STEP / steps.amax()).min(1.0);
            for (q, step) in q.iter_mut().zip(steps.iter()) {
                *q += shorten * step;
            }
            kinematics.update(self, &q)?;
            missing = displacement_between(kinematics.tool(), pose);
        }
        Err(StiffnessError::NoPose { iterations: MOST_ITERATIONS, missing: halves(&missing).0.norm() })
    }
}

/// `(J Jᵀ + λ² 1)⁻¹ x`: with `Jᵀ` before it, the damped least-squares step of the joints for a displacement `x`.
pub(crate) fn solve_damped(jacobian: &Matrix6xX<f64>, x: &Twist, damping: f64) -> Twist {
    let mut gram = Matrix6::from_diagonal_element(damping * damping);
    for column in jacobian.column_iter() {
        gram.ger(1.0, &column, &column, 1.0);
    }
    // Positive definite: the damping adds to a Gram matrix of finite numbers.
    gram.cholesky().map_or(Twist::zeros(), |factor| factor.solve(x))
}
