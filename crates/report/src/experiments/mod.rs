//! Experiments that identify parameters or tell explanations apart: text, JSON, tables, and figures.

mod figures;
mod files;
mod json;
mod text;

pub use figures::{discrimination_figure, identification_figure};
pub use files::{discrimination_table, experiment_inputs, identification_table};
pub use json::{discrimination_json, identification_json};
pub use text::{discrimination_text, identification_text};
