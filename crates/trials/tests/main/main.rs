//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod hidden_slider;
mod monte_carlo;
mod slider_logs;
