//! Every result as text, Markdown, LaTeX, HTML with MathML, JSON and figures.

mod affinization;
mod analysis;
mod analysis_pictures;
pub mod control;
mod diagnosis;
mod document;
pub mod html;
pub mod plate;
mod reach;
pub mod simulation;
pub mod stiffness;

pub use affinization::{AffinizationReport, InputChange};
pub use analysis::{Analysis, AnalysisError, analyze};
pub use diagnosis::{Diagnosis, RankChange, Ranks};
pub use html::Figure;
pub use reach::{Influence, ReachTable, Reached};
pub use simulation::{friction_bands, friction_colors};
