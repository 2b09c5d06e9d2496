//! What a planned trajectory commands, and what is left of it.

use super::interface::Command;
use crate::PlateError;
use bracketry_mpc::PlannedTrajectory;

/// Accelerations that do not move an object, m/s² and rad/s².
pub(super) const GENTLE: f64 = 0.05;
/// Rates of a plate that is about to rest, m/s and rad/s.
const SLOW: f64 = 0.02;

/// The command of a trajectory's first interval.
pub(super) fn command_of(trajectory: &PlannedTrajectory) -> Command {
    let u = trajectory.u(0);
    Command { displacement_acceleration: u[0], tilt_acceleration: u[1] }
}

/// Whether all that is left of a trajectory is rest: intervals by which it was made longer and that no program has used.
pub(super) fn is_over(trajectory: &PlannedTrajectory) -> bool {
    let gentle = |u: &[f64]| u.iter().all(|a| a.abs() < GENTLE);
    let x = trajectory.x(0);
    x[7].abs() < SLOW && x[9].abs() < SLOW && (0..trajectory.steps()).all(|k| gentle(trajectory.u(k)))
}

/// A trajectory without its first interval, and with intervals of rest at its end.
pub(super) fn rest_of(trajectory: &PlannedTrajectory, more: usize) -> Result<PlannedTrajectory, PlateError> {
    let steps = trajectory.steps();
    let mut x: Vec<Vec<f64>> = (1..=steps).map(|k| trajectory.x(k).to_vec()).collect();
    let mut u: Vec<Vec<f64>> = (1..steps).map(|k| trajectory.u(k).to_vec()).collect();
    for _ in 0..more {
        x.push(trajectory.x(steps).to_vec());
        u.push(vec![0.0; 2]);
    }
    Ok(PlannedTrajectory::from_rows(&x, &u)?)
}
