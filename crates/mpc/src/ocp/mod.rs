//! The optimal control problem as data: cost, bounds, constraints, and their values along a trajectory.

mod bounds;
mod branching;
mod constraint;
mod cost;
mod cost_names;
mod cost_norms;
mod cost_parts;
mod grid;
mod horizon_cost;
mod kept_bounds;
mod margins;
mod memory;
mod moves;
mod norm_widths;
mod previous_input;
mod problem;
mod scaled_rows;
mod shared_inputs;
mod trace;
mod vector_function;
mod violations;

pub use bounds::{Bounds, Softness};
pub use branching::Branching;
pub use constraint::{NormConstraint, PathConstraint, TerminalSet};
pub use cost::CostFunction;
pub use cost_names::CostKind;
pub(crate) use cost_names::{CostNames, CostPoint, Remembered, derivative_name};
pub(crate) use horizon_cost::HorizonCost;
pub use margins::Margins;
pub(crate) use moves::Moves;
pub(crate) use norm_widths::FINEST_ROUNDING;
pub use previous_input::PreviousInput;
pub use problem::{Ocp, Substeps, TerminalTarget};
pub(crate) use scaled_rows::{Rows, ScaledRows, coefficient_name, over_scaled_time};
pub use trace::{BoundSide, Bounded, ConstraintTrace, LargestViolation};
pub use vector_function::VectorFunction;
