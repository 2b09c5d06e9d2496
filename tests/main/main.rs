//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod analysis;
mod architecture;
mod chain;
mod classic_dynamics;
mod classic_models;
mod common;
mod delays;
mod diagnose_plate;
mod model_files;
mod plate_move;
mod steered_guess;
mod verdicts;
