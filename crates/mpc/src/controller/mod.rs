//! What answers measured states with inputs, sample by sample.

mod branches;
mod failure_policy;
mod interface;
mod previous_input;
mod rounded;
mod step;
mod sum_up_rounding;

pub(crate) use branches::{Branches, shown_branch};
pub use failure_policy::{Brake, FailurePolicy};
pub(crate) use failure_policy::{Failures, rest_input};
pub(crate) use interface::forward_to;
pub use interface::{Controller, PlanErrors};
pub(crate) use previous_input::WithPreviousInput;
pub(crate) use rounded::Rounded;
pub use step::{FallbackReason, InputSource, SolverEffort, Step, StepLimits, StepStatus, Timings};
pub use sum_up_rounding::SumUpRounding;
