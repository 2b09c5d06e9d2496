//! Inputs over the samples of an experiment.

use bracketry_sim::{Hold, InputError, Inputs, Samples};

/// A time before all that a delay may reach back to, s.
const LONG_AGO: f64 = -1e9;

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
    /// What drives a simulation. Before the start, every input has its value at rest: one that acts late is felt only after its delay.
    pub(crate) fn inputs(&self, rest: &[f64]) -> Result<Inputs, InputError> {
        let mut inputs = Inputs::new();
        for (j, name) in self.names.iter().enumerate() {
            let column = self.values.iter().map(|row| row[j]);
            let samples = match self.hold {
                Hold::Previous => {
                    let times = std::iter::once(LONG_AGO).chain(self.times.iter().copied()).collect();
                    Samples::new(times, std::iter::once(rest[j]).chain(column).collect(), Hold::Previous)?
                }
                // It starts from its value at rest.
                Hold::Linear => Samples::new(self.times.clone(), column.collect(), Hold::Linear)?,
            };
            inputs = inputs.samples(name, samples);
        }
        Ok(inputs)
    }
}
