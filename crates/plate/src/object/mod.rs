//! The object on the plate: its outline, thickness and mass, and where it presses on the plate.

mod bearing;
mod patch;
mod polygon;
mod prism;
mod quadrature;
mod shape;

pub use bearing::Bearing;
pub(crate) use patch::Patch;
pub use polygon::{ShapeError, Vertices};
pub use prism::Object;
pub use quadrature::Quadrature;
pub use shape::Shape;
