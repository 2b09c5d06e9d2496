//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod affine;
mod builder;
mod candidates;
mod formulas;
mod implicit;
mod input_delays;
mod input_ranges;
mod least_values;
mod model_files;
mod quantities;
mod quotients;
mod ranges;
mod static_levels;
mod unit_vectors;
mod units;
