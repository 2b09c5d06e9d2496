//! The guard against chattering.

use crate::friction::{FrictionMode, ZeroSet};
use crate::outcome::StopReason;
use crate::settings::SimulationSettings;
use std::collections::VecDeque;

/// What has happened lately.
#[derive(Debug, Clone, Default)]
pub(crate) struct Guard {
    /// Times of events.
    recent: VecDeque<f64>,
    /// Events since the last step.
    stalled: usize,
    /// Modes that could not be kept for any time at the present instant.
    pub(crate) failed: Vec<Vec<FrictionMode>>,
}

impl Guard {
    /// A step was taken.
    pub(crate) fn go_on(&mut self) {
        self.stalled = 0;
        self.failed.clear();
    }

    /// The past does not count any more.
    pub(crate) fn forget_events(&mut self) {
        self.recent.clear();
    }

    /// Counts an event at `t` of a system with this many switches.
    pub(crate) fn count(
        &mut self,
        t: f64,
        switches: usize,
        zero: &ZeroSet,
        settings: &SimulationSettings,
    ) -> Result<(), StopReason> {
        self.stalled += 1;
        if self.stalled > 8 + 9 * switches {
            return Err(StopReason::NoConsistentMode { switches: zero.switches() });
        }
        let (limit, window) = (settings.max_events, settings.event_window);
        self.recent.push_back(t);
        if self.recent.len() > limit
            && let Some(first) = self.recent.pop_front()
            && t - first <= window
        {
            return Err(StopReason::TooManyEvents { limit, window });
        }
        Ok(())
    }
}
