//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod collocation;
#[cfg(feature = "dense")]
mod dense;
mod eigen;
mod least_squares;
mod linear_equations;
mod matrix_equations;
#[cfg(feature = "dense")]
mod rows;
mod splines;
mod statistics;
