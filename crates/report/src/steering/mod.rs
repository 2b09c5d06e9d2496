//! Motions from one state to another: text, JSON, tables, and figures.

mod figures;
mod files;
mod json;
mod text;

pub use figures::{steering_figure, steering_path};
pub use files::{steering_inputs, steering_scenario, steering_trajectory};
pub use json::steering_json;
pub use text::steering_text;
