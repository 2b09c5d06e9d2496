//! Problem files: model, horizon, cost, constraints and run in one TOML file.

mod conditions;
mod constraints;
mod cost;
mod discrete_time;
mod document;
mod estimation;
mod free;
mod free_keys;
mod horizon;
mod initial_guess;
mod intervals;
mod rates;
mod reader;
mod scaling;
mod solve;
mod time_function;
