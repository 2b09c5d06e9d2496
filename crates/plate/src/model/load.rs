//! The normal load on an object that lies on the plate.

use crate::PlateKinematics;

/// Acceleration of gravity in m/s², as in the model files.
pub const GRAVITY: f64 = 9.81;

/// Normal load per mass in m/s² on an object whose center of mass is `height` above the plate, `g cos θ + y θ'' + 2 y' θ' −
/// h θ'²`: where it is negative, the object lifts off and models without flight say
/// nothing.
pub fn normal_load(state: &[f64; 6], plate: &PlateKinematics, height: f64) -> f64 {
    GRAVITY * plate.tilt.cos() + state[1] * plate.tilt_acceleration + 2.0 * state[4] * plate.tilt_rate
        - height * plate.tilt_rate.powi(2)
}
