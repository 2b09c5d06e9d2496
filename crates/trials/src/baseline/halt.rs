//! Bringing the plate to rest, and what a delayed command will meet.

use bracketry_plate::PlateKinematics;
use bracketry_plate::control::Command;
use std::collections::VecDeque;

/// Commands that have been given and do not act yet.
#[derive(Debug, Clone)]
pub(super) struct Pipeline {
    pending: VecDeque<Command>,
    period: f64,
}

impl Pipeline {
    /// A delay of `delay` samples.
    pub(super) fn new(delay: usize, period: f64) -> Self {
        Self { pending: std::iter::repeat_n(Command::default(), delay).collect(), period }
    }

    /// The plate at the instant from which on the next command will act.
    pub(super) fn predict(&self, now: &PlateKinematics) -> PlateKinematics {
        self.pending.iter().fold(*now, |plate, command| command.applied_to(&plate).after(self.period))
    }

    /// Gives a command.
    pub(super) fn send(&mut self, command: Command) -> Command {
        self.pending.push_back(command);
        self.pending.pop_front();
        command
    }
}

/// The acceleration that brings a coordinate and its rate to zero, held over `period`: time-optimal within four fifths of
/// `bound`, at the end in two periods (dead beat of the double integrator).
pub(super) fn halt(value: f64, rate: f64, period: f64, bound: f64) -> f64 {
    // Both rounded to rest.
    if value.abs() < 1e-9 && rate.abs() < 1e-9 {
        return -rate / period;
    }
    let first = -(value + 1.5 * period * rate) / (period * period);
    let second = -(rate + period * first) / period;
    if first.abs() <= bound && second.abs() <= bound {
        return first;
    }
    let ahead = value + period * rate;
    let wanted = -ahead.signum() * (1.6 * bound * ahead.abs()).sqrt();
    ((wanted - rate) / period).clamp(-bound, bound)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plate_comes_to_rest_at_zero_within_the_bound_and_in_little_more_than_the_least_time() {
        let (period, bound) = (5e-3, 2.0);
        for (start, rate) in [(0.1, 0.0), (-0.03, 0.3), (0.0, -0.5), (1e-4, 0.0), (0.08, 0.4)] {
            let mut plate = PlateKinematics { displacement: start, velocity: rate, ..PlateKinematics::default() };
            let mut steps = 0;
            while steps < 1000 && (plate.displacement.abs() > 1e-9 || plate.velocity.abs() > 1e-9) {
                plate.acceleration = halt(plate.displacement, plate.velocity, period, bound);
                assert!(plate.acceleration.abs() <= bound);
                plate = plate.after(period);
                steps += 1;
            }
            // The least time v/a + 2 √(x/a + v²/2a²), x and v counted toward the side of x + v|v|/2a.
            let side = (start + rate * f64::abs(rate) / (2.0 * bound)).signum();
            let root = (side * start / bound + 0.5 * (rate / bound).powi(2)).sqrt();
            let least = side * rate / bound + 2.0 * root;
            assert!(period * f64::from(steps) < 1.3 * least + 6.0 * period, "{start} {rate}: {steps} {least}");
        }
    }

    #[test]
    fn a_delayed_command_meets_the_plate_that_was_predicted() {
        let mut pipeline = Pipeline::new(2, 0.1);
        let mut plate = PlateKinematics::default();
        let command = |a| Command { displacement_acceleration: a, tilt_acceleration: -a };
        pipeline.send(command(1.0));
        pipeline.send(command(2.0));
        let predicted = pipeline.predict(&plate);
        for a in [1.0, 2.0] {
            (plate.acceleration, plate.tilt_acceleration) = (a, -a);
            plate = plate.after(0.1);
        }
        assert_eq!(predicted, plate);
    }
}
