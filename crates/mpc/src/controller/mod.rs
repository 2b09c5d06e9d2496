//! What answers measured states with inputs, sample by sample.

mod branches;
mod failure_policy;
mod interface;
mod remembering;
mod step;

pub(crate) use branches::{Branches, shown_branch};
pub use failure_policy::{Brake, FailurePolicy};
pub(crate) use failure_policy::{Failures, rest_input};
pub use interface::{Controller, Figures};
pub(crate) use remembering::Remembering;
pub use step::{FallbackReason, InputSource, Step, StepLimits, StepStatus, Timings};
