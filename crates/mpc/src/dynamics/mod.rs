//! The dynamics as the optimizer needs them: a field and its exact derivatives.

mod arguments;
mod field;
mod implicit;
mod second_derivatives;
mod symbolic;

pub(crate) use arguments::{Arguments, sparse_jacobian};
pub use field::{Dynamics, FieldDynamics};
pub use symbolic::SymbolicDynamics;
