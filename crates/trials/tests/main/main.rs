//! The tests of this crate: one program, a module for each topic.
#![allow(clippy::unwrap_used)]

mod baseline;
mod hidden_slider;
mod monte_carlo;
mod score;
mod slider_logs;
