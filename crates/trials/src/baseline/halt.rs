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
