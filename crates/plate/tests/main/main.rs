//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

#[path = "../../../../tests/main/common/tier.rs"]
mod tier;

mod area;
mod area_laws;
mod bearing;
mod body;
mod control;
mod derivation;
mod disk;
mod experiments;
mod first_principles;
mod learning;
mod move_planner;
mod publication;
mod random_object;
mod recording;
mod reduced;
mod shapes;
mod sign_comparison;
mod sweep;
mod velocity_field;
