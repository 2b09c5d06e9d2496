//! The dynamics as the optimizer needs them: a field and its exact derivatives.

mod field;
mod second_derivatives;
mod symbolic;

pub use field::{Dynamics, FieldDynamics};
pub use symbolic::SymbolicDynamics;
