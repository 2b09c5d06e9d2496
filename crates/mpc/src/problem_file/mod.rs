//! Problem files: model, horizon, cost, constraints and run in one TOML file.

mod conditions;
mod constraints;
mod cost;
mod document;
mod estimation;
mod horizon;
mod initial_guess;
mod reader;
mod scaling;
mod solve;
