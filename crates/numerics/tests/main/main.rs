//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod collocation;
mod dense;
mod eigen;
mod equations;
mod splines;
mod statistics;
