//! Frames, and how wrenches and small displacements move between them.

use crate::error::{StiffnessError, check_entries};
use nalgebra::{Isometry3, Matrix3, Matrix6, Translation3, UnitQuaternion, Vector3, Vector6};

/// Force (N) and moment (N·m) of a load on the robot.
pub type Wrench = Vector6<f64>;

/// A small displacement: translation (m) and rotation vector (rad).
pub type Twist = Vector6<f64>;

/// The matrix of `v ×`.
pub(crate) fn cross_matrix(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// The adjoint that carries wrenches from a frame into the one its `pose` is given in:
/// `f ↦ R f`, `m ↦ R m + p × R f`.
pub fn wrench_adjoint(pose: &Isometry3<f64>) -> Matrix6<f64> {
    adjoint(pose, (3, 0))
}

/// The adjoint that carries small displacements of a rigid body from a frame into the one its `pose` is given in:
/// `t ↦ R t + p × R r`, `r ↦ R r`. Work is the same in both: `twist_adjointᵀ wrench_adjoint = 1`.
pub fn twist_adjoint(pose: &Isometry3<f64>) -> Matrix6<f64> {
    adjoint(pose, (0, 3))
}

/// R twice on the diagonal, `p × R` in one of the other blocks.
fn adjoint(pose: &Isometry3<f64>, lever: (usize, usize)) -> Matrix6<f64> {
    let r = *pose.rotation.to_rotation_matrix().matrix();
    let mut adjoint = Matrix6::zeros();
    for (block, value) in [((0, 0), r), ((3, 3), r), (lever, cross_matrix(&pose.translation.vector) * r)] {
        adjoint.fixed_view_mut::<3, 3>(block.0, block.1).copy_from(&value);
    }
    adjoint
}

/// `[first; last]`.
pub(crate) fn stacked(first: &Vector3<f64>, last: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(first.x, first.y, first.z, last.x, last.y, last.z)
}

/// Its force or translation, and its moment or rotation.
pub(crate) fn halves(v: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (v.fixed_rows::<3>(0).into(), v.fixed_rows::<3>(3).into())
}

/// Refuses a wrench with an entry that is not finite.
pub(crate) fn check_wrench(wrench: &Wrench) -> Result<(), StiffnessError> {
    check_entries("wrench", wrench.as_slice())
}

/// What a wrench at `point`, in base axes, is at a frame, in its axes.
pub(crate) fn wrench_in(frame: &Isometry3<f64>, point: &Vector3<f64>, wrench: &Wrench) -> Wrench {
    let (force, moment) = halves(wrench);
    let arm = point - frame.translation.vector;
    let back = frame.rotation.inverse();
    stacked(&(back * force), &(back * (moment + arm.cross(&force))))
}

/// A frame after a displacement in the axes that its pose is given in: its origin moves by the translation, its axes turn by the
/// rotation vector.
pub fn displaced(pose: &Isometry3<f64>, by: &Twist) -> Isometry3<f64> {
    let (translation, rotation) = halves(by);
    Isometry3::from_parts(
        Translation3::from(pose.translation.vector + translation),
        UnitQuaternion::new(rotation) * pose.rotation,
    )
}

/// The displacement `[ΔP; ΔR]` that leads from one pose to another, both in the same axes: `ΔP = p₂ − p₁`, `ΔR` the rotation
/// vector of `R₂ R₁ᵀ` (its logarithm). The inverse of [`displaced`] for rotations below half a turn.
pub fn displacement_between(from: &Isometry3<f64>, to: &Isometry3<f64>) -> Twist {
    let translation = to.translation.vector - from.translation.vector;
    let rotation = (to.rotation * from.rotation.inverse()).scaled_axis();
    stacked(&translation, &rotation)
}
