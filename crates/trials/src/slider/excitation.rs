//! Forces that drive the slider.

use rand::RngExt;
use rand::rngs::StdRng;
use std::f64::consts::TAU;

/// How the slider is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Excitation {
    /// A sum of sines of equal amplitudes, with frequencies and phases drawn at random.
    Multisine {
        /// Lowest frequency, Hz.
        low: f64,
        /// Highest frequency, Hz.
        high: f64,
        /// Number of sines.
        lines: usize,
    },
    /// A sine of constant amplitude whose frequency rises in proportion to time.
    Chirp {
        /// First frequency, Hz.
        low: f64,
        /// Last frequency, Hz.
        high: f64,
    },
    /// Levels drawn uniformly from both signs, each held for a time drawn at random.
    Levels {
        /// Shortest time, s.
        shortest: f64,
        /// Longest time, s.
        longest: f64,
    },
}

impl Excitation {
    /// A multisine whose band and number of lines are drawn: from 0.1–0.5 Hz to 2.5–4.5 Hz with 8–30 sines. The rms frequency is
    /// near 2 Hz, so that a delay of 8 ms shifts the force by 2π · 2 Hz · 8 ms ≈ 10 % of its rms.
    pub fn random_multisine(random: &mut StdRng) -> Self {
        Self::Multisine {
            low: random.random_range(0.1..0.5),
            high: random.random_range(2.5..4.5),
            lines: random.random_range(8..=30),
        }
    }

    /// Any kind, with its figures drawn.
    pub fn random(random: &mut StdRng) -> Self {
        match random.random_range(0..4) {
            0 | 1 => Self::random_multisine(random),
            2 => Self::Chirp { low: random.random_range(0.2..0.6), high: random.random_range(2.5..5.0) },
            _ => Self::Levels { shortest: random.random_range(0.05..0.1), longest: random.random_range(0.3..0.5) },
        }
    }

    /// Its values at `times` (s, increasing), not scaled.
    pub(super) fn samples(&self, times: &[f64], random: &mut StdRng) -> Vec<f64> {
        let Some((&first, &last)) = times.first().zip(times.last()) else { return Vec::new() };
        match *self {
            Self::Multisine { low, high, lines } => {
                let sines: Vec<(f64, f64)> =
                    (0..lines).map(|_| (TAU * uniform(random, low, high), uniform(random, 0.0, TAU))).collect();
                times
                    .iter()
                    .map(|t| sines.iter().map(|(frequency, phase)| (frequency * t + phase).sin()).sum())
                    .collect()
            }
            Self::Chirp { low, high } => {
                let phase = uniform(random, 0.0, TAU);
                let rate = (high - low) / (last - first);
                let angle = |t: f64| TAU * (low + rate * t / 2.0) * t + phase;
                times.iter().map(|t| angle(t - first).sin()).collect()
            }
            Self::Levels { shortest, longest } => {
                let (mut until, mut level) = (first, 0.0);
                let mut at = |t: f64| {
                    while t >= until {
                        level = uniform(random, -1.0, 1.0);
                        until += uniform(random, shortest, longest);
                    }
                    level
                };
                times.iter().map(|&t| at(t)).collect()
            }
        }
    }
}

/// A number drawn uniformly between `low` and `high`.
fn uniform(random: &mut StdRng, low: f64, high: f64) -> f64 {
    low + (high - low) * random.random_range(0.0..1.0)
}
