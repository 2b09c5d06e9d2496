//! Shaking the plate periodically, with three numbers that set the direction in which the object drifts.

use bracketry_plate::{Harmonic, PeriodicMotion, PlateKinematics};
use std::f64::consts::{PI, TAU};

/// Frequency in Hz.
pub(super) const FREQUENCY: f64 = 2.5;
/// Period in s.
pub(super) const CYCLE: f64 = 1.0 / FREQUENCY;
/// First harmonic of the displacement in m: `|X''|` exceeds the friction by far, so that the object always slips along x and
/// any force across moves it.
const SHAKE: f64 = 0.03;
/// Greatest second harmonic of the displacement in m.
const ASYMMETRY: f64 = 0.005;
/// Greatest mean tilt in rad.
const SLOPE: f64 = 0.1;
/// Greatest first harmonic of the tilt in rad: 40 rad/s².
const SWING: f64 = 40.0 / (TAU * FREQUENCY * TAU * FREQUENCY);

/// A periodic motion of the plate: `X = a sin ωt + b cos 2ωt`, `θ = c + d sin ωt`. Shaking with `a` fixed alone moves the object to
/// and fro; `b` makes it drift along x, `c` along y, and `d` turns it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cycle {
    /// How strongly the plate shakes, from 0 (at rest) to 1.
    pub shake: f64,
    /// The second harmonic of the displacement, as a share from −1 to 1.
    pub asymmetry: f64,
    /// The mean tilt, as a share from −1 to 1.
    pub slope: f64,
    /// The first harmonic of the tilt, as a share from −1 to 1.
    pub swing: f64,
}

impl Cycle {
    /// Full shaking with the three shares.
    pub fn drifting([asymmetry, slope, swing]: [f64; 3]) -> Self {
        Self { shake: 1.0, asymmetry, slope, swing }
    }

    /// The motion.
    pub fn motion(&self) -> PeriodicMotion {
        let harmonic = |amplitude, phase| Harmonic { amplitude, phase };
        PeriodicMotion {
            frequency: FREQUENCY,
            displacement: vec![harmonic(SHAKE * self.shake, 0.0), harmonic(ASYMMETRY * self.asymmetry, 0.5 * PI)],
            tilt: vec![harmonic(SWING * self.swing, 0.0)],
            mean_tilt: SLOPE * self.slope,
        }
    }

    fn shares(&self) -> [f64; 4] {
        [self.shake, self.asymmetry, self.slope, self.swing]
    }

    /// The plate `t` seconds after the start of a cycle in which the motion goes over from `before` to `self`, smoothly and
    /// over the whole cycle: with plate and rates continuous from one cycle to the next, and at rest where nothing shakes.
    pub fn after(&self, before: &Self, t: f64) -> PlateKinematics {
        let s = (t / CYCLE).clamp(0.0, 1.0);
        // Quintic blend with vanishing first and second derivatives at both ends.
        let blend = [
            s * s * s * (10.0 + s * (6.0 * s - 15.0)),
            30.0 * (s * (1.0 - s)).powi(2) / CYCLE,
            60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (CYCLE * CYCLE),
        ];
        let (from, to) = (before.shares(), self.shares());
        let omega = TAU * FREQUENCY;
        let (sin, cos) = (omega * t).sin_cos();
        let (sin2, cos2) = (2.0 * omega * t).sin_cos();
        let first = [sin, omega * cos, -omega * omega * sin];
        let second = [cos2, -2.0 * omega * sin2, -4.0 * omega * omega * cos2];
        let basis = [(SHAKE, first), (ASYMMETRY, second), (SLOPE, [1.0, 0.0, 0.0]), (SWING, first)];
        let term = |i: usize| {
            let (size, wave) = basis[i];
            let change = to[i] - from[i];
            let share = [from[i] + change * blend[0], change * blend[1], change * blend[2]];
            [
                size * share[0] * wave[0],
                size * (share[1] * wave[0] + share[0] * wave[1]),
                size * (share[2] * wave[0] + 2.0 * share[1] * wave[1] + share[0] * wave[2]),
            ]
        };
        let sum = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let [displacement, velocity, acceleration] = sum(term(0), term(1));
        let [tilt, tilt_rate, tilt_acceleration] = sum(term(2), term(3));
        PlateKinematics { displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration }
    }
}
