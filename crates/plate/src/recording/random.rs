//! Random numbers of recordings and trials: a generator for each trial, whatever the order in which they run.

use bracketry_symbolic::SplitMix64;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::TAU;

/// Random numbers from a seed.
#[derive(Debug)]
pub struct Random(StdRng);

impl Random {
    /// Of a seed.
    pub fn new(seed: u64) -> Self {
        Self(StdRng::seed_from_u64(seed))
    }

    /// Uniform between two numbers, which may be equal.
    pub fn between(&mut self, [low, high]: [f64; 2]) -> f64 {
        low + (high - low) * self.0.random_range(0.0..1.0)
    }

    /// Normally distributed with mean 0 and standard deviation 1, by the transformation of Box and Muller (1958): the recorded
    /// studies are drawn with it, and `rand_distr` would take other numbers from the generator.
    pub fn normal(&mut self) -> f64 {
        let (radius, angle) = (1.0 - self.0.random_range(0.0..1.0), TAU * self.0.random_range(0.0..1.0));
        (-2.0 * f64::ln(radius)).sqrt() * f64::cos(angle)
    }

    /// One of the numbers below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count)
    }

    /// True with a probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.0.random_range(0.0..1.0) < probability
    }
}

/// The seed of number `index` of a series of trials: that number of the sequence of [`SplitMix64`].
pub fn seed_of(seed: u64, index: u64) -> u64 {
    SplitMix64::at(seed, index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_the_moments_of_their_distribution() {
        let mut random = Random::new(1);
        let numbers: Vec<f64> = (0..40_000).map(|_| random.normal()).collect();
        let mean = |power: i32| numbers.iter().map(|x| x.powi(power)).sum::<f64>() / numbers.len() as f64;
        // Five standard errors: 1, √2, √96 over √40000.
        assert!(mean(1).abs() < 0.025 && (mean(2) - 1.0).abs() < 0.036 && (mean(4) - 3.0).abs() < 0.25);
    }
}
