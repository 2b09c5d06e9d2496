//! What the extended model is worth, on data that played no part in the fits.

mod bootstrap;
mod equation;
mod evaluation;
mod horizon;
mod measure;
mod missing;
mod motion;
mod report;
mod rest;
mod trial;

pub use bootstrap::bootstrap;
pub(crate) use bootstrap::middle;
pub use equation::{ForceResidual, force_error, force_residuals};
pub use horizon::Predicted;
pub use measure::{Fitted, HeldOut, measure_gain};
pub(crate) use missing::{Missing, MissingIn, missing};
pub use report::Gain;
