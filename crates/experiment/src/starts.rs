//! Inputs from which the optimization starts, and with which its result is compared.

use crate::plan::Pieces;
use crate::setup::Setup;
use bracketry_symbolic::SplitMix64;

/// How often square waves bring a mass back: the more often, the stronger they may be within limits of its position.
const RETURNS: [f64; 2] = [1.0, 4.0];
/// Share of the duration that the slowest of the random inputs holds a value.
const LONGEST_HOLD: f64 = 0.3;

impl Setup {
    /// Simple inputs of the full limits: a step, a step there and back, a square wave of rising frequency, and square waves that bring a mass back
    /// to where it was. They are the references.
    pub(crate) fn simple(&self) -> Vec<Pieces> {
        let steps = self.pieces.len() - 1;
        let shape = |f: &dyn Fn(f64) -> f64| {
            let row = |k: usize| {
                let value = f((k as f64 + 0.5) / steps as f64);
                self.inputs.iter().map(|u| along(u.rest, u.range, value)).collect::<Vec<f64>>()
            };
            self.chosen(&(0..steps).map(row).collect::<Vec<_>>())
        };
        let chirp = |s: f64| (std::f64::consts::TAU * (s + 4.0 * s * s)).sin().signum();
        let back = |count: f64| move |s: f64| (std::f64::consts::TAU * count * s).cos().signum();
        let [slow, fast] = RETURNS.map(back);
        vec![shape(&|_| 1.0), shape(&|s| if s < 0.5 { 1.0 } else { -1.0 }), shape(&chirp), shape(&slow), shape(&fast)]
    }

    /// Random inputs: every one holds random values for random times, which differ by orders of magnitude from input to input.
    pub(crate) fn random(&self, count: usize, seed: u64) -> Vec<Pieces> {
        let mut random = SplitMix64::new(seed);
        let steps = self.pieces.len() - 1;
        let mut draw = || {
            let mut rows = vec![vec![0.0; self.inputs.len()]; steps];
            for (j, input) in self.inputs.iter().enumerate() {
                let slow = LONGEST_HOLD * (steps as f64 * LONGEST_HOLD).powf(-random.uniform());
                let switching = random.uniform() < 0.5;
                let (mut value, mut left) = (0.0, 0.0);
                for row in &mut rows {
                    if left <= 0.0 {
                        let next = random.symmetric();
                        value = if switching { next.signum() } else { next };
                        left = slow * steps as f64 * (0.5 + random.uniform());
                    }
                    left -= 1.0;
                    row[j] = along(input.rest, input.range, value);
                }
            }
            self.chosen(&rows)
        };
        (0..count).map(|_| draw()).collect()
    }
}

/// From the value at rest to the greatest (1) and to the least value (−1); where these are the same as the value at rest, from one end to the
/// other.
fn along(rest: f64, [low, high]: [f64; 2], value: f64) -> f64 {
    if rest == low || rest == high {
        return low + (high - low) * f64::midpoint(value, 1.0);
    }
    if value >= 0.0 { rest + value * (high - rest) } else { rest + value * (rest - low) }
}

/// Inputs that are weaker by a factor: closer to rest.
pub(crate) fn weaker(setup: &Setup, pieces: &Pieces, factor: f64) -> Pieces {
    let weak = |row: &Vec<f64>| {
        let values = row.iter().zip(&setup.inputs);
        values.map(|(v, u)| if setup.is_linear() { factor * v } else { u.rest + factor * (v - u.rest) }).collect()
    };
    pieces.iter().map(weak).collect()
}
