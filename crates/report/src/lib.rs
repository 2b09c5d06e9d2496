//! Every result as text, Markdown, LaTeX, HTML with MathML, JSON and figures.
//!
//! ```
//! use bracketry_lie::{AnalysisOptions, analyze};
//! use bracketry_system::System;
//! let text = "states = ['x', 'y', 'th']\ninputs = ['v', 'w']\ndynamics = { x = 'v*cos(th)', y = 'v*sin(th)', th = 'w' }";
//! let unicycle = System::parse("unicycle.toml", text).unwrap();
//! let analysis = analyze(&unicycle, &AnalysisOptions::default()).unwrap();
//! assert!(bracketry_report::analysis::text(&analysis).contains("accessible"));
//! ```

pub mod analysis;
pub mod certificates;
pub mod control;
mod control_signals;
mod curves;
mod diagnosis;
pub mod experiments;
pub mod export;
pub mod forms;
pub mod from_rest;
pub mod html;
pub mod identifiability;
mod notation;
pub mod operating;
mod paragraphs;
pub mod parameters;
pub mod plate;
pub mod publication;
pub mod reproduced;
pub mod simulation;
pub mod steering;
pub mod stiffness;

pub use diagnosis::{Diagnosis, DiagnosisJson, NextExperiment, rank_change_text, text as diagnosis_text};
pub use html::Figure;
pub use simulation::{friction_bands, friction_colors};
