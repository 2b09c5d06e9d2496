//! A steering problem as the methods see it.

use bracketry_symbolic::{Limit, StopFlag};
use bracketry_system::System;

use crate::options::SteerOptions;
use crate::ranges::Ranges;
use crate::signals::Signals;
use crate::steering::{Plan, SteerReason};

/// The model, the two states, and limits.
#[derive(Clone)]
pub(crate) struct Problem {
    /// The model as it was given.
    pub(crate) given: System,
    /// With integrators in front of the inputs whose derivatives it uses.
    pub(crate) system: System,
    pub(crate) options: SteerOptions,
    pub(crate) ranges: Ranges,
    pub(crate) limit: Limit,
}

/// Inputs made by a method, before they are checked.
pub(crate) struct Planned {
    pub(crate) signals: Signals,
    pub(crate) plan: Plan,
}

/// Plans in the order in which they are to be tried, at least one.
pub(crate) type Outcome = Result<Vec<Planned>, SteerReason>;

impl Problem {
    pub(crate) fn stop(&self) -> &StopFlag {
        &self.limit.stop
    }

    /// Whether time is up, memory runs out, or somebody asked to stop.
    pub(crate) fn is_over(&self) -> bool {
        self.limit.is_reached()
    }
}
