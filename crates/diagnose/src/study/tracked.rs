//! Measurements of a point off the center of mass of a body.

use crate::effect::Change;
use crate::error::DiagnoseError;
use crate::library::state_index;
use bracketry_system::System;

/// The states of a body in the plane whose tracked point lies off its center of mass, by index; see [`Change::TrackedPoint`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TrackedPoint {
    position: [usize; 2],
    velocity: [usize; 2],
    pub(super) angle: usize,
    pub(super) spin: usize,
}

/// How a measured state differs from that of the center of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Shift {
    /// What it shows more.
    pub(super) value: f64,
    /// Its derivative by the angle.
    pub(super) by_angle: f64,
    /// Its derivative by the spin.
    pub(super) by_spin: f64,
}

impl TrackedPoint {
    /// The states of a change by name; absent for other changes.
    pub(super) fn new(system: &System, change: &Change) -> Result<Option<Self>, DiagnoseError> {
        let Change::TrackedPoint { position, velocity, angle, spin } = change else { return Ok(None) };
        let index = |name: &String| state_index(system, name);
        Ok(Some(Self {
            position: [index(&position[0])?, index(&position[1])?],
            velocity: [index(&velocity[0])?, index(&velocity[1])?],
            angle: index(angle)?,
            spin: index(spin)?,
        }))
    }

    /// What a state shows more where its measurement is that of the point at `d` (m, in axes of the body); nothing for states that are
    /// neither its position nor its velocity.
    pub(super) fn shift(&self, state: usize, (angle, spin): (f64, f64), d: [f64; 2]) -> Shift {
        let (sin, cos) = angle.sin_cos();
        let arm = [cos * d[0] - sin * d[1], sin * d[0] + cos * d[1]];
        if state == self.position[0] {
            Shift { value: arm[0], by_angle: -arm[1], by_spin: 0.0 }
        } else if state == self.position[1] {
            Shift { value: arm[1], by_angle: arm[0], by_spin: 0.0 }
        } else if state == self.velocity[0] {
            Shift { value: -spin * arm[1], by_angle: -spin * arm[0], by_spin: -arm[1] }
        } else if state == self.velocity[1] {
            Shift { value: spin * arm[0], by_angle: -spin * arm[1], by_spin: arm[0] }
        } else {
            Shift::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocities_and_slopes_are_derivatives_of_the_shift() {
        let point = TrackedPoint { position: [0, 1], velocity: [3, 4], angle: 2, spin: 5 };
        let (angle, spin, d, h) = (0.7, 2.5, [0.004, -0.003], 1e-6);
        let at = |state, a, w| point.shift(state, (a, w), d).value;
        for (position, velocity) in [(0, 3), (1, 4)] {
            let moving = (at(position, angle + spin * h, spin) - at(position, angle - spin * h, spin)) / (2.0 * h);
            assert!((at(velocity, angle, spin) - moving).abs() < 1e-9);
        }
        for state in 0..6 {
            let shift = point.shift(state, (angle, spin), d);
            let by_angle = (at(state, angle + h, spin) - at(state, angle - h, spin)) / (2.0 * h);
            let by_spin = (at(state, angle, spin + h) - at(state, angle, spin - h)) / (2.0 * h);
            assert!((shift.by_angle - by_angle).abs() < 1e-9 && (shift.by_spin - by_spin).abs() < 1e-9);
        }
    }
}
