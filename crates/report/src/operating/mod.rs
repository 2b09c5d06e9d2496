//! Operating points and linear systems: text, JSON, and files for other programs.

mod files;
mod json;
mod text;

pub use files::{LinearFile, linear_files};
pub use json::{linear_json, trim_json};
pub use text::{linear_text, trim_text};
