//! How late the plate follows its commands.

use super::interface::Command;
use super::learned::Estimate;
use super::limits::PlateLimits;
use crate::PlateKinematics;

/// Standard deviation of the lag assumed at first, in s: it follows at once.
const FIRST: f64 = 0.01;
/// Standard deviation of a change of rates that the lag does not explain, as a share of what the greatest accelerations give.
const UNEXPLAINED: f64 = 0.02;
/// Longest lag that is accepted, in periods.
const LONGEST: f64 = 2.0;
/// Lags below this time in s are none.
const LEAST: f64 = 2e-4;

/// The time by which a servo lags behind its commands, from the measured motion of the plate: over a period, the rates change by
/// `period · u_k + T (u_{k−1} − u_k)` if the accelerations `u` arrive `T` late, and by the same to first order with a first-order
/// lag of time constant `T`. Linear least squares.
#[derive(Debug, Clone)]
pub(super) struct ServoLag {
    /// Sum of the squared changes of the commands, and of their products with what is missing.
    square: f64,
    product: f64,
}

impl ServoLag {
    pub(super) fn new() -> Self {
        Self { square: 0.0, product: 0.0 }
    }

    /// Takes in a period: the rates before and after, the command that acted, and the one before it.
    pub(super) fn take(
        &mut self,
        [from, to]: [&PlateKinematics; 2],
        [before, acted]: [Command; 2],
        period: f64,
        limits: &PlateLimits,
    ) {
        let axes = [
            (
                from.velocity,
                to.velocity,
                before.displacement_acceleration,
                acted.displacement_acceleration,
                limits.displacement_acceleration,
            ),
            (from.tilt_rate, to.tilt_rate, before.tilt_acceleration, acted.tilt_acceleration, limits.tilt_acceleration),
        ];
        for (from, to, before, acted, limit) in axes {
            let (missing, change) = ((to - from - period * acted) / limit, (before - acted) / limit);
            if missing.is_finite() {
                self.square += change * change;
                self.product += change * missing;
            }
        }
    }

    /// The lag in s.
    pub(super) fn estimate(&self, period: f64) -> Estimate {
        let noise = UNEXPLAINED * period;
        let information = self.square / (noise * noise) + 1.0 / (FIRST * FIRST);
        let value = self.product / (noise * noise) / information;
        let value = if value < LEAST { 0.0 } else { value.min(LONGEST * period) };
        Estimate { value, deviation: 1.0 / information.sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_command_shows_its_delay_and_a_prompt_one_that_there_is_none() {
        let (period, limits) = (0.02, PlateLimits::default());
        for delay in [0.0, 0.008, 0.015] {
            let mut lag = ServoLag::new();
            let (mut plate, mut before) = (PlateKinematics::default(), Command::default());
            assert_eq!(lag.estimate(period).value, 0.0);
            for sample in 0..50 {
                let phase = 0.4 * f64::from(sample);
                let acted =
                    Command { displacement_acceleration: 10.0 * phase.sin(), tilt_acceleration: 30.0 * phase.cos() };
                let after = before.applied_to(&plate).after(delay);
                let after = acted.applied_to(&after).after(period - delay);
                lag.take([&plate, &after], [before, acted], period, &limits);
                (plate, before) = (after, acted);
            }
            let Estimate { value, deviation } = lag.estimate(period);
            assert!((value - delay).abs() < 3.0 * deviation.min(1e-4), "{value} ± {deviation} instead of {delay}");
        }
    }
}
