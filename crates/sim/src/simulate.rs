//! A whole simulation in one call.

use crate::{Outcome, SimError, SimulationSettings, Statistics, Stepper, Switched, Trajectory};

/// The result of [`simulate`].
#[derive(Debug, Clone)]
pub struct Simulation {
    /// States at any time, transitions, modes.
    pub trajectory: Trajectory,
    /// How it ended.
    pub outcome: Outcome,
    /// Work done.
    pub statistics: Statistics,
}

/// Integrates `system` from the state `x0` at `t0` to `t_end`.
///
/// # Errors
/// [`SimError`] for a state of the wrong length, a time span that is not one, or settings without meaning. Whatever
/// happens during the simulation is told by [`Simulation::outcome`].
pub fn simulate(
    system: impl Switched,
    t0: f64,
    x0: &[f64],
    t_end: f64,
    settings: &SimulationSettings,
) -> Result<Simulation, SimError> {
    let mut stepper = Stepper::new(system, t0, x0, settings)?;
    let (trajectory, outcome) = stepper.record(t_end)?;
    Ok(Simulation { trajectory, outcome, statistics: stepper.statistics() })
}
