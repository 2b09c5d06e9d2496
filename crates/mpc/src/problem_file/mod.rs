//! Problem files: model, horizon, cost, constraints and run in one TOML file.

mod chance;
mod conditions;
mod constraints;
mod cost;
mod discrete_time;
mod document;
mod estimation;
mod finite_inputs;
mod free;
mod free_keys;
mod horizon;
mod initial_guess;
mod intervals;
mod periodic;
mod rates;
mod reader;
mod references;
mod scaling;
mod scenarios;
mod solve;
mod time_function;
mod tree;
mod uncertainty;
mod units;
