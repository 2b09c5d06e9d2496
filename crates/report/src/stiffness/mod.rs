//! Robot stiffness: identification, choice of poses, weighing and compensation as text, Markdown, JSON and figures.

pub mod figures;
pub mod json;
pub mod markdown;
pub mod text;
