//! Normal forms and decompositions: text, JSON, and the model file.

mod json;
mod text;

pub use json::transformation_json;
pub use text::{part_text, transformation_model, transformation_text};
