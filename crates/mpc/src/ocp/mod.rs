//! The optimal control problem as data: cost, bounds, constraints, and their values along a trajectory.

mod bounds;
mod constraint;
mod cost;
mod problem;
mod vector_function;
mod violations;

pub use bounds::{Bounds, Softness};
pub use constraint::{NormConstraint, PathConstraint, TerminalSet};
pub use cost::{CostFunction, CostKind};
pub(crate) use cost::{CostNames, CostPoint};
pub use problem::{Ocp, Substeps, TerminalTarget};
pub use vector_function::VectorFunction;
