//! Robot stiffness: identification, choice of poses, weighing and compensation as text, Markdown, JSON, figures, and pages.

pub mod figures;
pub mod json;
pub mod markdown;
pub mod page;
mod tables;
pub mod text;
