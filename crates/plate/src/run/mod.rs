//! One experiment on one of the models of the object's contact, perhaps beside a log or driven by it.

mod bearing_option;
mod comparison;
mod equations;
mod error;
mod experiment;
mod footprint_model;
mod imposed_motion;
mod log_signs;
mod object_model;
mod option_text;
mod option_values;
mod options;
mod period_start;
mod point_table;
mod pose_deviations;
mod result;
mod setup;
mod sign_comparison;
mod simulate;

pub use comparison::Comparison;
pub use error::PlateRunError;
pub use experiment::{PlateExperiment, PlateOutcome};
pub use option_values::{ExperimentKind, FrictionLaw};
pub use options::{GivenOption, NumberOption, PlateOptions, SetupError, TextOption};
pub use period_start::{PeriodStart, SignSource};
pub use pose_deviations::{Deviation, PoseDeviations};
pub use result::{Assumption, PlateRow, PlateRun, PlateStop};
pub use setup::{PlateModel, PlateSetup};
pub use sign_comparison::{Dependence, ErrorsAtStart, OppositeSigns, ScaledInput, SignComparison, SignStatus};
