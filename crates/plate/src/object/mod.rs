//! The object on the plate: its outline, thickness and mass.

mod polygon;
mod prism;
mod quadrature;
mod shape;

pub use polygon::{ShapeError, Vertices};
pub use prism::Object;
pub use quadrature::Quadrature;
pub use shape::Shape;
