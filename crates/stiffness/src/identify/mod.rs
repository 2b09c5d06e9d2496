//! From measured displacements under measured loads to stiffnesses, with what is known about them and what is not.

mod cartesian;
mod comparison;
mod conventions;
mod error;
mod estimators;
mod levenberg_marquardt;
mod outliers;
mod parameters;
mod poses;
mod scaled;
mod springs;

pub use cartesian::{CartesianEstimate, CartesianEstimator, identify_cartesian};
pub use comparison::{Attenuation, Comparison, Found, Method, MethodReport, compare};
pub use error::{IdentificationError, Place};
pub use outliers::Outliers;
pub use parameters::DeformationModel;
pub use poses::{PoseChoice, PoseInformation};
pub use springs::{Identified, SpringFit, SpringFitSettings, SpringParameter, fit_springs};
