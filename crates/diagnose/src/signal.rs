//! Columns of a recorded run.

use bracketry_sim::Hold;

/// What a measured column stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// A state, by index.
    State(usize),
    /// An output of the model, by index.
    Output(usize),
}

/// A measured column.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Name of the column.
    pub name: String,
    /// What it measures.
    pub quantity: Quantity,
    /// One value per time; NaN where it was lost.
    pub values: Vec<f64>,
    /// Standard deviation of the noise, in the column's unit, estimated from the column itself.
    pub noise: f64,
}

/// The samples of one input or of one derivative of an input.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// One finite value per time.
    pub values: Vec<f64>,
    /// How it continues between samples.
    pub hold: Hold,
}

impl Measured {
    /// Variance of the values that are there, in the square of the column's unit.
    pub(crate) fn variance(&self) -> f64 {
        let known: Vec<f64> = self.values.iter().copied().filter(|v| v.is_finite()).collect();
        let n = known.len().max(1) as f64;
        let mean = known.iter().sum::<f64>() / n;
        known.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
    }
}
