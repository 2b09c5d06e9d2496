//! Verdicts as functions of parameters: text, JSON, and a map.

mod figure;
mod json;
mod text;

pub use figure::parameter_figure;
pub use json::{parameter_json, parameter_map_json};
pub use text::{parameter_map_text, parameter_text};
