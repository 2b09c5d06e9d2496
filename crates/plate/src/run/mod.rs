//! One experiment on one of the models of the object's contact, perhaps beside a log or driven by it.

mod comparison;
mod equations;
mod error;
mod experiment;
mod footprint_model;
mod imposed_motion;
mod object_model;
mod option_values;
mod options;
mod result;
mod setup;
mod simulate;

pub use comparison::{Comparison, Deviation};
pub use error::PlateRunError;
pub use experiment::{PlateExperiment, PlateOutcome};
pub use option_values::{ExperimentKind, FrictionLaw};
pub use options::{GivenOption, NumberOption, PlateOptions, SetupError, TextOption};
pub use result::{Assumption, PlateRow, PlateRun, PlateStop};
pub use setup::{PlateModel, PlateSetup};
