//! Robots from files, with measurements and logs from tables: identification, choice of poses, weighing, compensation.

mod compensation;
mod error;
mod identification;
mod log;
mod loop_gain;
mod poses;
mod residual;
mod weighing;

pub use compensation::{CompensatedLog, CompensatedRow, FaultCount};
pub use error::StiffnessRunError;
pub use identification::{Identification, MethodFigures, Withheld};
pub use log::{RobotLog, TWIST_COLUMNS, WRENCH_COLUMNS};
pub use loop_gain::LoopGain;
pub use poses::{ChosenPoses, Expectation};
pub use residual::{PredictedTranslation, SpringResidual};
pub use weighing::Weighing;
