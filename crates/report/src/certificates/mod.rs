//! Certificates: text, JSON, and the picture of a region of attraction.

mod figure;
mod json;
mod text;

pub use figure::region_figure;
pub use json::certification_json;
pub use text::{certification_text, check_text};
