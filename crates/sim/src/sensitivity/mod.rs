//! What small changes of the state and of the field lead to along a simulation.

mod path;
mod saltation;
mod tangent;

pub use path::Path;
pub use saltation::Saltation;
pub use tangent::Tangent;

pub(crate) use path::FieldBefore;
