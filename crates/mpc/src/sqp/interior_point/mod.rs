//! A primal–dual interior-point method for smooth problems, from any guess.
//!
//! Constraints c(w) + s ≥ 0 become c + s = t with the barrier −μ Σ ln t; Newton's method solves the conditions of optimality for a
//! decreasing μ, with the exact Hessian of the Lagrangian. Curvature is added where that is not positive definite on the directions that
//! obey the dynamics, steps are accepted by a filter, after a correction of second order if need be, and where none is, defects are
//! removed first (Wächter and Biegler 2006). Every linear system is solved stage by stage, by a Riccati
//! recursion (FATROP: Vanroye, Sathya, De Schutter, and Decré 2023).

mod direction;
mod iterate;
mod restoration;
mod solver;

pub(crate) use solver::{BARRIERS, InteriorPoint, InteriorSolution};
