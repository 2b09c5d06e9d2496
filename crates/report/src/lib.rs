//! Every result as text, Markdown, LaTeX, HTML with MathML, JSON and figures.

pub mod analysis;
pub mod certificates;
pub mod control;
mod control_signals;
mod diagnosis;
pub mod export;
pub mod forms;
pub mod html;
pub mod identifiability;
mod notation;
pub mod operating;
pub mod parameters;
pub mod plate;
pub mod simulation;
pub mod steering;
pub mod stiffness;

pub use diagnosis::{Diagnosis, DiagnosisJson, RankChange, Ranks, text as diagnosis_text};
pub use html::Figure;
pub use simulation::{friction_bands, friction_colors};
