//! From measured displacements under measured loads to stiffnesses, with what is known about them and what is not.

mod cartesian;
mod comparison;
mod conventions;
mod error;
mod estimators;
mod lost_motion;
mod measurement;
mod minimum;
mod outliers;
mod parameters;
mod poses;
mod scaled;
mod spring_parameter;
mod springs;
mod statistics;
mod uncertainty;

pub use cartesian::{CartesianEstimate, CartesianEstimator, identify_cartesian};
pub use comparison::{Advice, Attenuation, Comparison, Found, Method, MethodReport, compare};
pub use error::{IdentificationError, Place, Unloaded};
pub use lost_motion::{LostMotion, LostMotionReport, ResidualSample, explain_residual};
pub use measurement::{Measurement, MeasurementNoise, MeasurementSet};
pub use outliers::Outliers;
pub use poses::{PoseChoice, PoseInformation};
pub use spring_parameter::{Identified, SpringParameter, Unidentified};
pub use springs::{SpringFit, SpringFitSettings, fit_springs};

pub(crate) use uncertainty::NOT_IDENTIFIED;
