//! Sequential quadratic programming to convergence.
//!
//! There are two iterations, and each takes over where the other one does not converge:
//!
//! - Smooth dynamics start with the filter method, which may pass through large defects.
//! - Smoothed switching functions start with the guarded iteration, sharpened along a schedule of widths; between two widths it
//!   is enough to be near the solution. Each program has a proximal term λ/2 ‖Δ/trust‖², and the whole step is taken when the
//!   exact ℓ₁ merit function falls by enough of what the program predicted, else λ grows (Levenberg–Marquardt with slacks: the
//!   program is always feasible). On the plate the filter method alone takes more
//!   programs, and feedback along its plans made up for less of a wrong friction coefficient.
//!
//! The example `random_starts` counts programs: the guarded iteration solves all of its moves of the plate, but a cart-pole
//! with dry friction from 2 of 30 starts alone, and from 27 with the filter method after it.

mod controller;
mod filter;
mod filter_iteration;
mod settings;
mod solution;
mod solver;

pub use controller::SqpController;
pub use settings::{Hessian, SqpSettings};
pub use solution::{Iteration, Solution, SolveStatus};
pub use solver::Sqp;
