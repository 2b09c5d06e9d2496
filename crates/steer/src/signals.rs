//! Inputs over time.

use bracketry_sim::{Hold, InputError, Inputs, Samples};

/// Inputs as a table: one row of values per time.
#[derive(Clone, Debug, PartialEq)]
pub struct Signals {
    /// Increasing times in seconds, from 0 to the end of the motion.
    pub times: Vec<f64>,
    /// One row per time with one value per input of the model.
    pub values: Vec<Vec<f64>>,
    /// Whether a value holds until the next time, or changes along a straight line.
    pub hold: Hold,
}

impl Signals {
    /// The length of the motion.
    pub fn duration(&self) -> f64 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The column of an input for the simulation.
    ///
    /// # Errors
    /// [`InputError::BadSamples`] for numbers that are no signal.
    pub fn column(&self, input: usize) -> Result<Samples, InputError> {
        Samples::new(self.times.clone(), self.values.iter().map(|row| row[input]).collect(), self.hold)
    }

    /// What drives the inputs of these names.
    ///
    /// # Errors
    /// [`InputError::BadSamples`] for numbers that are no signal.
    pub fn inputs(&self, names: &[String]) -> Result<Inputs, InputError> {
        let mut inputs = Inputs::new();
        for (j, name) in names.iter().enumerate() {
            inputs = inputs.samples(name, self.column(j)?);
        }
        Ok(inputs)
    }

    /// Largest absolute value of an input.
    pub(crate) fn largest(&self, input: usize) -> f64 {
        self.values.iter().fold(0.0, |most, row| row[input].abs().max(most))
    }

    /// The same motion of a model without drift in another time: x(t) becomes x(t/k), u(t) becomes u(t/k)/k.
    pub(crate) fn slowed(mut self, k: f64) -> Self {
        self.times.iter_mut().for_each(|t| *t *= k);
        self.values.iter_mut().flatten().for_each(|u| *u /= k);
        self
    }

    /// Whether every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.times.iter().chain(self.values.iter().flatten()).all(|v| v.is_finite())
    }
}
