//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod collocation;
#[cfg(feature = "dense")]
mod dense;
mod eigen;
mod equations;
mod least_squares;
#[cfg(feature = "dense")]
mod rows;
mod splines;
mod statistics;
