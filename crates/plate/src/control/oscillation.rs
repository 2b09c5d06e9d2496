//! Plain oscillations of the plate: what the planner's search starts from.

use std::f64::consts::TAU;

/// Displacement and tilt that swing together, faded in and out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Oscillation {
    /// Frequency in Hz.
    pub(super) frequency: f64,
    /// Amplitude of the displacement in m.
    pub(super) displacement: f64,
    /// Amplitude of the tilt in rad.
    pub(super) tilt: f64,
    /// Phase of the displacement before the tilt in rad.
    pub(super) phase: f64,
}

impl Oscillation {
    /// The accelerations `X''`, `θ''` over `steps` intervals of `dt` seconds, from second differences of the motion.
    pub(super) fn inputs(&self, steps: usize, dt: f64) -> Vec<Vec<f64>> {
        let end = steps as f64 * dt;
        let fade = 0.25f64.min(end / 4.0);
        let motion = |t: f64| {
            let part = (t.min(end - t) / fade).clamp(0.0, 1.0);
            let window = part * part * (3.0 - 2.0 * part);
            let angle = TAU * self.frequency * t;
            [self.displacement * window * (angle + self.phase).sin(), self.tilt * window * angle.sin()]
        };
        let half = dt / 2.0;
        (0..steps)
            .map(|k| {
                let t = (k as f64 + 0.5) * dt;
                let (before, at, after) = (motion(t - half), motion(t), motion(t + half));
                (0..2).map(|i| (after[i] - 2.0 * at[i] + before[i]) / (half * half)).collect()
            })
            .collect()
    }
}
