//! An object on a plate with imposed motion: experiments, sweeps, and velocity fields run on it.

use crate::PlateError;
use crate::motion::Drive;
use bracketry_sim::{Outcome, Trajectory};

/// States of an object on the plate: position of the center of mass in the plate frame (m), yaw (rad), and their rates.
pub const STATES: [&str; 6] = ["x", "y", "phi", "vx", "vy", "w"];

/// An object on a moving plate, with states [`STATES`].
pub trait DrivenObject: Clone {
    /// States at any time of a recorded span.
    type Course: Course;

    /// Current time in seconds.
    fn time(&self) -> f64;

    /// Current state.
    fn state(&self) -> [f64; 6];

    /// Puts the object into another state at another time.
    ///
    /// # Errors
    /// [`PlateError`] if time or state are not finite.
    fn set_state(&mut self, t: f64, state: [f64; 6]) -> Result<(), PlateError>;

    /// Moves the plate otherwise from now on. At the beginning it stays still. A jump of the displacement or of its rate
    /// gives the object no impulse.
    ///
    /// # Errors
    /// [`PlateError`] if the motion does not fit.
    fn drive(&mut self, drive: &Drive) -> Result<(), PlateError>;

    /// Sets one of the motion's named numbers; false if there is none of that name.
    fn set_number(&mut self, name: &str, value: f64) -> bool;

    /// Simulates to `t_end` and records the trajectory.
    ///
    /// # Errors
    /// [`PlateError`] if `t_end` is not finite or lies in the past. A simulation that ends early is an [`Outcome`].
    fn record(&mut self, t_end: f64) -> Result<(Self::Course, Outcome), PlateError>;
}

/// The states of an object over a span of time.
pub trait Course: Clone {
    /// First time in seconds.
    fn start(&self) -> f64;

    /// Last time in seconds.
    fn end(&self) -> f64;

    /// The state at `t`; outside the span, the first or the last.
    fn state_at(&self, t: f64) -> [f64; 6];

    /// Joins a later course that begins where this one ends.
    fn join(&mut self, later: &Self);
}

impl Course for Trajectory {
    fn start(&self) -> f64 {
        self.start()
    }

    fn end(&self) -> f64 {
        self.end()
    }

    fn state_at(&self, t: f64) -> [f64; 6] {
        let mut state = [0.0; 6];
        self.sample_into(t, &mut state);
        state
    }

    fn join(&mut self, later: &Self) {
        self.append(later);
    }
}
