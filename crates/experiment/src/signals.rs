//! Inputs over the samples of an experiment.

use bracketry_sim::{Hold, InputError, Inputs, Samples};

/// Inputs at the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Signals {
    /// Times of the samples, s.
    pub times: Vec<f64>,
    /// Names of the inputs.
    pub names: Vec<String>,
    /// One row per sample.
    pub values: Vec<Vec<f64>>,
    /// How the inputs continue between samples.
    pub hold: Hold,
}

impl Signals {
    /// What drives a simulation.
    pub(crate) fn inputs(&self) -> Result<Inputs, InputError> {
        let mut inputs = Inputs::new();
        for (j, name) in self.names.iter().enumerate() {
            // A value that is held is one sample: a simulation stops at each.
            let changes =
                |k: &usize| self.hold == Hold::Linear || *k == 0 || self.values[*k][j] != self.values[*k - 1][j];
            let kept: Vec<usize> = (0..self.times.len()).filter(changes).collect();
            let times = kept.iter().map(|k| self.times[*k]).collect();
            let column = kept.iter().map(|k| self.values[*k][j]).collect();
            inputs = inputs.samples(name, Samples::new(times, column, self.hold)?);
        }
        Ok(inputs)
    }
}
