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
            let column = self.values.iter().map(|row| row[j]).collect();
            inputs = inputs.samples(name, Samples::new(self.times.clone(), column, self.hold)?);
        }
        Ok(inputs)
    }
}
