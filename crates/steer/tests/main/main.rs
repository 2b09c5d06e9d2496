//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod chained;
mod common;
mod flat_and_shooting;
mod from_rest;
mod nilpotent;
