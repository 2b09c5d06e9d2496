//! Motion from rest to rest: text, JSON, and figures.

mod figures;
mod json;
mod map;
mod text;

pub use figures::from_rest_cones;
pub use json::from_rest_json;
pub use map::{from_rest_map_figure, from_rest_map_json, from_rest_map_text};
pub use text::from_rest_text;
