//! Motion from rest to rest: text, JSON, and figures.

mod figures;
mod json;
mod text;

pub use figures::from_rest_cones;
pub use json::from_rest_json;
pub use text::from_rest_text;
