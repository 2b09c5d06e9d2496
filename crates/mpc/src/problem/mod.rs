//! Control problems: model, horizon, cost, method and run together.

mod cause;
mod choice;
mod conditions;
mod control_problem;
mod estimates;
mod estimation;
mod findings;
mod found_values;
mod free_values;
mod method;
mod notes;
mod on_plant;
mod rehearsal;
mod report;
mod run;
mod schedule;
mod signs;
mod start;
mod verdict;

pub use cause::Cause;
pub use conditions::RunConditions;
pub(crate) use control_problem::FreeValues;
pub use control_problem::{ControlProblem, ProblemError};
pub use estimation::{Estimation, EstimatorKind};
pub use found_values::FoundValues;
pub use method::{Convergence, Feedback, Method, MethodReason};
pub use notes::{FirstSample, Note};
pub use on_plant::{ControlError, Controlled, control, control_watched};
pub use report::{ClosedLoopReport, KeptRange, PlanReport, ViolationReport};
pub use run::ControlRun;
pub use schedule::{ReferenceUse, Schedule, Scheduled};
