//! Serial robots: their chain of joints, frames and wrenches, forward and inverse kinematics, URDF.

mod chain;
mod frame;
mod inverse;
mod kinematics;
mod urdf;
mod urdf_document;

pub use chain::{DhParameters, Joint, JointKind, Robot};
pub use frame::{Twist, Wrench, displaced, displacement_between, twist_adjoint, wrench_adjoint};
pub use kinematics::Kinematics;
pub use urdf::UrdfError;

pub(crate) use frame::{check_wrench, cross_matrix, halves, stacked, wrench_in};
pub(crate) use inverse::solve_damped;
