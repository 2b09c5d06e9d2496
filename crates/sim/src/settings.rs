//! Tolerances and limits of a simulation, and the errors of wrong ones.

use bracketry_symbolic::StopFlag;
use serde::{Deserialize, Serialize};

/// Tolerances and limits of a simulation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SimulationSettings {
    /// Relative tolerance of the local error of every state.
    pub rtol: f64,
    /// Absolute tolerance of the local error of every state.
    pub atol: f64,
    /// Longest step in seconds.
    pub max_step: f64,
    /// Most accepted and rejected steps of one call.
    pub max_steps: usize,
    /// Most events within [`SimulationSettings::event_window`]: the guard against chattering (Zeno behavior).
    pub max_events: usize,
    /// Length in seconds of the window in which events are counted.
    pub event_window: f64,
    /// Most switching functions that may vanish at once for the full enumeration of the `3^|Z|` next modes; for
    /// more, an active-set search is tried.
    pub max_zero_set: usize,
    /// Once it is raised, the simulation stops where it is ([`crate::StopReason::Asked`]).
    #[serde(skip)]
    pub stop: StopFlag,
}

impl Default for SimulationSettings {
    fn default() -> Self {
        Self {
            rtol: 1e-9,
            atol: 1e-11,
            max_step: f64::INFINITY,
            max_steps: 10_000_000,
            max_events: 1000,
            event_window: 1e-3,
            max_zero_set: 8,
            stop: StopFlag::default(),
        }
    }
}

impl SimulationSettings {
    /// Both tolerances at once.
    #[must_use]
    pub fn with_tolerance(mut self, rtol: f64, atol: f64) -> Self {
        self.rtol = rtol;
        self.atol = atol;
        self
    }

    /// The longest step in seconds.
    #[must_use]
    pub fn with_max_step(mut self, max_step: f64) -> Self {
        self.max_step = max_step;
        self
    }

    /// At most `max_events` events within any `window` seconds.
    #[must_use]
    pub fn with_event_limit(mut self, max_events: usize, window: f64) -> Self {
        self.max_events = max_events;
        self.event_window = window;
        self
    }

    /// Error allowed in a state of this size.
    pub(crate) fn scale(&self, size: f64) -> f64 {
        self.atol + self.rtol * size
    }

    /// Checks that every field has a meaning.
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let positive = |name, value: f64| {
            if value > 0.0 { Ok(()) } else { Err(SimError::BadSetting { name, value }) }
        };
        positive("rtol", self.rtol)?;
        positive("atol", self.atol)?;
        positive("max_step", self.max_step)?;
        positive("event_window", self.event_window)?;
        positive("max_steps", self.max_steps as f64)?;
        positive("max_events", self.max_events as f64)?;
        positive("max_zero_set", self.max_zero_set as f64)
    }
}

/// Misuse of the simulator. What happens *during* a simulation is a [`crate::StopReason`], not an error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SimError {
    /// A vector has the wrong length.
    #[error("{what} has {found} entries, the system needs {expected}")]
    WrongLength {
        /// Which vector.
        what: &'static str,
        /// The length needed.
        expected: usize,
        /// The length given.
        found: usize,
    },
    /// A setting without meaning.
    #[error("the setting {name} = {value} must be positive")]
    BadSetting {
        /// The field of [`SimulationSettings`].
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A time that is not a number, or an end before the start.
    #[error("the time span from {from} to {to} is not valid")]
    BadTimeSpan {
        /// Start.
        from: f64,
        /// End.
        to: f64,
    },
}
