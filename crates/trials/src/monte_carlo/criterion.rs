//! When an object counts as being at its target.

use bracketry_plate::PlateKinematics;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Greatest rates of a plate that is at rest, in m/s and rad/s: above rounding, far below what moves an object.
pub(crate) const REST: f64 = 1e-6;

/// How close to the target is close enough.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// Greatest error along x and along y, each, in m.
    pub position: f64,
    /// Greatest error of the yaw in rad.
    pub angle: f64,
}

impl Tolerance {
    /// Whether an error `x, y` (m), `phi` (rad) is within the tolerance in position and in angle.
    pub fn holds(&self, error: [f64; 3]) -> [bool; 2] {
        let [x, y, phi] = error.map(f64::abs);
        [x <= self.position && y <= self.position, phi <= self.angle]
    }
}

/// Object and plate at an instant of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialSample {
    /// Time in s.
    pub t: f64,
    /// State of the object, `x, y, phi, vx, vy, w`.
    pub object: [f64; 6],
    /// Motion of the plate.
    pub plate: PlateKinematics,
}

/// The error of a pose: the yaw to the nearest whole turn, in (−π, π].
pub fn pose_error(pose: [f64; 3], target: [f64; 3]) -> [f64; 3] {
    let turn = (pose[2] - target[2]).rem_euclid(TAU);
    [pose[0] - target[0], pose[1] - target[1], if turn > PI { turn - TAU } else { turn }]
}

/// Whether the plate rests: both rates below 1 µm/s and 1 µrad/s.
pub fn at_rest(plate: &PlateKinematics) -> bool {
    plate.velocity.abs() <= REST && plate.tilt_rate.abs() <= REST
}

/// The first instant from which on, to the last sample, the object is within the tolerance of its target while the plate
/// rests. An arrival while the plate still moves does not count, nor one after which the object leaves again.
///
/// ```
/// use bracketry_plate::PlateKinematics;
/// use bracketry_trials::{Tolerance, TrialSample, time_to_target};
/// let at = |t, x| TrialSample { t, object: [x, 0.0, 0.0, 0.0, 0.0, 0.0], plate: PlateKinematics::default() };
/// let tolerance = Tolerance { position: 1e-3, angle: 0.02 };
/// let course = [at(0.0, 0.1), at(0.1, 0.0), at(0.2, 0.1), at(0.3, 0.0), at(0.4, 0.0)];
/// assert_eq!(time_to_target(&course, [0.0; 3], tolerance), Some(0.3));
/// ```
pub fn time_to_target(samples: &[TrialSample], target: [f64; 3], tolerance: Tolerance) -> Option<f64> {
    let there = |sample: &TrialSample| {
        let [x, y, phi, ..] = sample.object;
        at_rest(&sample.plate) && tolerance.holds(pose_error([x, y, phi], target)) == [true; 2]
    };
    let first = samples.iter().rposition(|sample| !there(sample)).map_or(0, |last_miss| last_miss + 1);
    samples.get(first).map(|sample| sample.t)
}
