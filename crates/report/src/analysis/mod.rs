//! What inputs reach and outputs tell, and affine forms: as text, Markdown, LaTeX, JSON, figures, and a page.

pub(crate) mod affinization;
mod document;
mod feedback_text;
mod figures;
mod json;
mod lists;
mod page;
pub(crate) mod summary;
pub(crate) mod text;

pub use affinization::{AffinizationReport, InputChange, candidates, changes, method_name};
pub use document::{latex, markdown};
pub use figures::{growth_figure, reach_figure};
pub use json::{AnalysisJson, json};
pub use page::{dimensions, figures, page};
pub use summary::summary;
pub use text::{report_text, text};
