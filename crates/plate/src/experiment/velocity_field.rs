//! Cycle-averaged velocities of an object under periodic plate motions.

use super::sweep::sweep;
use crate::driven::least_load;
use crate::{DrivenObject, PeriodicMotion, PlateError};
use bracketry_sim::Outcome;
use std::ops::ControlFlow;

/// When a mean velocity counts as established.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Establishing {
    /// Most periods.
    pub periods: usize,
    /// Greatest change of `vx`, `vy` (m/s) and `w` (rad/s) from the start of a period to its end.
    pub tolerance: f64,
}

impl Default for Establishing {
    /// At most 200 periods, to 1e-6.
    fn default() -> Self {
        Self { periods: 200, tolerance: 1e-6 }
    }
}

/// The mean velocity of an object at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct MeanVelocity {
    /// Means of `x'`, `y'` (m/s) and `phi'` (rad/s) over the last period.
    pub mean: [f64; 3],
    /// Periods that it took.
    pub periods: usize,
    /// Whether the velocities repeat; if not, the mean is that of the last period allowed.
    pub established: bool,
    /// Least normal load per mass in m/s² in that period; see [`normal_load`](crate::model::normal_load), without thickness.
    pub least_load: f64,
    /// How the simulation ended.
    pub outcome: Outcome,
}

/// The cycle-averaged velocity of an object at the place `(x, y, phi)`.
///
/// Definition: let `P(v)` be the velocities `(x', y', phi')` after one period of the motion that begins at the place with the
/// velocities `v`. The object starts at rest, `v = 0`; after each period it is put back to the place and keeps its velocities,
/// `v ← P(v)`, until they repeat within the tolerance. The mean velocity is the displacement over that last period divided by its length.
/// The clock is put back as well, so that an object that never slips has the mean velocity zero exactly.
///
/// # Errors
/// [`PlateError`] if the motion does not fit the object.
pub fn mean_velocity<P: DrivenObject>(
    object: &mut P,
    motion: &PeriodicMotion,
    place: [f64; 3],
    establishing: Establishing,
) -> Result<MeanVelocity, PlateError> {
    let drive = motion.drive()?;
    let period = 1.0 / motion.frequency;
    let [x, y, phi] = place;
    let mut v = [0.0; 3];
    object.set_state(0.0, [x, y, phi, 0.0, 0.0, 0.0])?;
    object.drive(&drive)?;
    let mut kinematics = drive.motion()?;
    let mut result =
        MeanVelocity { mean: v, periods: 0, established: false, least_load: f64::INFINITY, outcome: Outcome::Finished };
    while result.periods < establishing.periods && !result.established {
        object.set_state(0.0, [x, y, phi, v[0], v[1], v[2]])?;
        let (course, outcome) = object.record(period)?;
        result.least_load = least_load(&course, &mut kinematics, 0.0);
        let end = object.state();
        result.periods += 1;
        result.outcome = outcome;
        if !result.outcome.is_finished() {
            break;
        }
        result.mean = std::array::from_fn(|i| (end[i] - place[i]) / period);
        let after = [end[3], end[4], end[5]];
        result.established =
            v.iter().zip(after).all(|(before, after)| (after - before).abs() <= establishing.tolerance);
        v = after;
    }
    Ok(result)
}

/// The mean velocities at many places, in parallel; see [`mean_velocity`] and, for `progress` and the order, [`sweep`].
pub fn velocity_field<P: DrivenObject + Sync>(
    object: &P,
    motion: &PeriodicMotion,
    places: &[[f64; 3]],
    establishing: Establishing,
    progress: impl Fn(usize) -> ControlFlow<()> + Sync,
) -> Vec<Option<Result<MeanVelocity, PlateError>>> {
    sweep(places, |&place| mean_velocity(&mut object.clone(), motion, place, establishing), progress)
}
