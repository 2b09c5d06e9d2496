//! Tests of the design of experiments.
#![allow(clippy::unwrap_used)]

mod common;
mod explanations;
mod parameters;
