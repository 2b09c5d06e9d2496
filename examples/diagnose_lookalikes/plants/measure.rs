//! What stands between a quantity and its column: colored noise, steps, a table.

use std::fmt::Write;

use rand::RngExt;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// Uniform between `low` and `high`.
pub(super) fn between(random: &mut StdRng, low: f64, high: f64) -> f64 {
    random.random_range(low..high)
}

/// Either sign.
pub(super) fn sign(random: &mut StdRng) -> f64 {
    if random.random_bool(0.5) { 1.0 } else { -1.0 }
}

/// First-order colored noise of a given standard deviation and corner frequency (Hz), sampled every `dt`.
pub(super) struct Colored {
    keep: f64,
    kick: f64,
    value: f64,
}

impl Colored {
    pub(super) fn new(std: f64, corner: f64, dt: f64) -> Self {
        let keep = (-std::f64::consts::TAU * corner * dt).exp();
        Self { keep, kick: std * (1.0 - keep * keep).sqrt(), value: 0.0 }
    }

    pub(super) fn next(&mut self, random: &mut StdRng) -> f64 {
        let kick: f64 = StandardNormal.sample(random);
        self.value = self.keep * self.value + self.kick * kick;
        self.value
    }
}

/// An encoder: noise of the electronics, then steps.
pub(super) struct Encoder {
    noise: Colored,
    step: f64,
}

impl Encoder {
    pub(super) fn new(step: f64, dt: f64) -> Self {
        Self { noise: Colored::new(0.3 * step, 0.1 / dt, dt), step }
    }

    pub(super) fn read(&mut self, value: f64, random: &mut StdRng) -> f64 {
        ((value + self.noise.next(random)) / self.step).round() * self.step
    }
}

/// A table as CSV.
pub(super) struct Table(String);

impl Table {
    pub(super) fn new(header: &str) -> Self {
        Self(format!("{header}\n"))
    }

    pub(super) fn row(&mut self, values: &[f64]) {
        for (i, v) in values.iter().enumerate() {
            let separator = if i == 0 { "" } else { "," };
            let _ = write!(self.0, "{separator}{v:.9}");
        }
        self.0.push('\n');
    }

    pub(super) fn text(self) -> String {
        self.0
    }
}
