//! Tests of the design of experiments.
#![allow(clippy::unwrap_used)]

mod explanations;
mod parameters;
