//! The imposed motion of the plate.

mod drive;
mod expression;
mod kinematics;
mod periodic;

pub use drive::Drive;
pub use expression::ExpressionMotion;
pub use kinematics::{PlateKinematics, PlateMotion};
pub use periodic::{Harmonic, PeriodicMotion};
