//! Implicit time stepping of dry contact by convex optimization.
//!
//! A body of `N` velocity coordinates touches something at points with slip velocities `J_i v`, `J_i` of two rows. Maximum
//! dissipation makes one implicit step of its motion, with bounds `b_i` on the friction forces that are known, the strictly
//! convex problem (Moreau 1988; Stewart and Trinkle 1996)
//!
//! ```text
//! min ½ (v − v*)ᵀ M (v − v*) + Σ c_i |J_i v|,      c_i = dt b_i,   v* the velocity without friction
//! ```
//!
//! whose optimality reads `M (v − v*) + Σ J_iᵀ λ_i = 0`, `|λ_i| ≤ c_i`, `λ_i = c_i J_i v/|J_i v|` where the point slips.
//! [`FrictionSolver`] solves it exactly: where everything is held, `v` is zero and not small, and a point the body pivots
//! about does not slip.

mod points;
mod small;
mod solver;
mod statics;

pub use points::FrictionPoints;
pub use solver::{ContactError, ContactStep, FrictionSolver, Slip};
