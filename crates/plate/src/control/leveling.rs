//! How a move is broken off: the plate goes back to its middle and levels, so that friction stops the object.

use super::interface::Command;
use super::limits::PlateLimits;
use crate::{GRAVITY, PlateKinematics};

/// Rate in 1/s at which displacement and tilt decay, critically damped.
const RATE: f64 = 8.0;
/// Share of gravity that the tilt's acceleration may take at the object's far side, and the distance in m to there.
const LIFT: f64 = 0.5;
const REACH: f64 = 0.15;
/// Tilt (rad) and displacement (m) with their rates that count as level and at rest, in units of the decay.
const LEVEL: f64 = 3e-3;

/// The command that takes plate and tilt a step toward level and at rest with the object at `y` (m); absent once they are.
pub(super) fn leveling(plate: &PlateKinematics, y: f64, limits: &PlateLimits, margin: f64) -> Option<Command> {
    let level = |value: f64, rate: f64| value.abs() < LEVEL && rate.abs() < LEVEL * RATE;
    if level(plate.tilt, plate.tilt_rate) && plate.velocity.abs() < LEVEL * RATE {
        return None;
    }
    let decay = |value: f64, rate: f64, limit: f64| (-RATE * (RATE * value + 2.0 * rate)).clamp(-limit, limit);
    let share = 1.0 - margin;
    // Gently enough for the object to stay down, but stopping before the bound comes first.
    let room = (share * limits.tilt - plate.tilt.abs()).max(1e-3);
    let outward = (plate.tilt_rate * plate.tilt.signum()).max(0.0);
    let gentle = (LIFT * GRAVITY / (y.abs() + REACH)).max(0.5 * outward * outward / room);
    let turning = gentle.min(share * limits.tilt_acceleration);
    Some(Command {
        displacement_acceleration: decay(plate.displacement, plate.velocity, share * limits.displacement_acceleration),
        tilt_acceleration: if outward * outward > turning * room {
            -turning.copysign(plate.tilt)
        } else {
            decay(plate.tilt, plate.tilt_rate, turning)
        },
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_plate_comes_to_rest_level_within_its_bounds() {
        let limits = PlateLimits::default();
        for (displacement, velocity, tilt, tilt_rate) in [(0.09, 0.3, -0.25, -2.5), (-0.05, -0.4, 0.32, 0.5)] {
            let mut plate = PlateKinematics { displacement, velocity, tilt, tilt_rate, ..PlateKinematics::default() };
            let mut samples = 0;
            while let Some(command) = leveling(&plate, 0.1, &limits, 0.05) {
                plate = command.applied_to(&plate).after(0.02);
                assert!(plate.displacement.abs() <= limits.stroke && plate.tilt.abs() <= limits.tilt);
                samples += 1;
                assert!(samples < 75);
            }
            assert!(plate.tilt.abs() < 3e-3);
        }
    }
}
