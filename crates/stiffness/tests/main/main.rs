//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod common;
mod compensate;
mod compensate_circle;
mod identify_cartesian;
mod identify_refusals;
mod identify_springs;
mod identities;
mod payload;
mod publication;
mod reference;
mod robot_file;
