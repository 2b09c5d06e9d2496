//! Control problems: model, horizon, cost, method and run together.

mod conditions;
mod control_problem;
mod estimation;
mod method;
mod notes;
mod on_plant;
mod report;
mod run;

pub use conditions::RunConditions;
pub use control_problem::{ControlProblem, ProblemError};
pub use estimation::{Estimation, EstimatorKind};
pub use method::{Convergence, Feedback, Method};
pub use notes::{FirstSample, Note};
pub use on_plant::{ControlError, Controlled, control, control_watched};
pub use report::{ClosedLoopReport, KeptRange, PlanReport};
pub use run::ControlRun;
