//! Frames, and how wrenches and small displacements move between them.

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
    let r = *pose.rotation.to_rotation_matrix().matrix();
    let mut adjoint = Matrix6::zeros();
    adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&r);
    adjoint.fixed_view_mut::<3, 3>(3, 0).copy_from(&(cross_matrix(&pose.translation.vector) * r));
    adjoint
}

/// The adjoint that carries small displacements of a rigid body from a frame into the one its `pose` is given in:
/// `t ↦ R t + p × R r`, `r ↦ R r`. Work is the same in both: `twist_adjointᵀ wrench_adjoint = 1`.
pub fn twist_adjoint(pose: &Isometry3<f64>) -> Matrix6<f64> {
    let r = *pose.rotation.to_rotation_matrix().matrix();
    let mut adjoint = Matrix6::zeros();
    adjoint.fixed_view_mut::<3, 3>(0, 0).copy_from(&r);
    adjoint.fixed_view_mut::<3, 3>(3, 3).copy_from(&r);
    adjoint.fixed_view_mut::<3, 3>(0, 3).copy_from(&(cross_matrix(&pose.translation.vector) * r));
    adjoint
}

/// What a wrench at `point`, in base axes, is at a frame, in its axes.
pub(crate) fn wrench_in(frame: &Isometry3<f64>, point: &Vector3<f64>, wrench: &Wrench) -> Wrench {
    let force: Vector3<f64> = wrench.fixed_rows::<3>(0).into();
    let moment: Vector3<f64> = wrench.fixed_rows::<3>(3).into();
    let arm = point - frame.translation.vector;
    let back = frame.rotation.inverse();
    let (f, m) = (back * force, back * (moment + arm.cross(&force)));
    Wrench::new(f.x, f.y, f.z, m.x, m.y, m.z)
}

/// A frame after a displacement in the axes that its pose is given in: its origin moves by the translation, its axes turn by the
/// rotation vector.
pub fn displaced(pose: &Isometry3<f64>, by: &Twist) -> Isometry3<f64> {
    let translation: Vector3<f64> = by.fixed_rows::<3>(0).into();
    let rotation: Vector3<f64> = by.fixed_rows::<3>(3).into();
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
    Twist::new(translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z)
}
