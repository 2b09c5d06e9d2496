//! Springs of joints and links: the deformation under a load and the tangent compliance at the tool point.

mod deformation;
mod spring;
mod tangent;

pub use deformation::{Deformation, DeformationModel};
pub use spring::{JointSpring, Springs};
pub use tangent::{geometric_stiffness, loaded_compliance};

pub(crate) use deformation::{Deflections, DeformedFrames};
