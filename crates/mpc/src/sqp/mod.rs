//! Sequential quadratic programming to convergence.
//!
//! There are three iterations:
//!
//! - Smooth dynamics start from a guess with an interior-point method for the nonlinear program (`interior_point`), which converges
//!   from far away; from another first barrier too where it takes long.
//! - The filter method confirms what that found and follows the solution from sample to sample. It starts from the guess itself where
//!   the interior-point method does not converge or does not take the problem, and once more closer to what the dynamics can do where
//!   it does not converge either.
//! - Smoothed switching functions start with the guarded iteration, sharpened along a schedule of widths; between two widths it
//!   is enough to be near the solution. Each program has a proximal term λ/2 ‖Δ/trust‖², and the whole step is taken when the
//!   exact ℓ₁ merit function falls by enough of what the program predicted, else λ grows (Levenberg–Marquardt with slacks: the
//!   program is always feasible). On the plate the filter method alone takes more
//!   programs, and feedback along its plans compensated less of a wrong friction coefficient.
//!
//! The example `random_starts` counts programs: the guarded iteration solves all of its moves of the plate, but a cart-pole
//! with dry friction from 2 of 30 starts alone, and from 27 with the filter method after it.

mod attempts;
mod controller;
mod filter;
mod filter_iteration;
mod interior_point;
mod kinks;
mod settings;
mod solution;
mod solver;
mod trajectory_pool;

pub use controller::SqpController;
pub use settings::{Hessian, SqpSettings};
pub use solution::{Iteration, Solution, SolveStatus};
pub use solver::Sqp;
