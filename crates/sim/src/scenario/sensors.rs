//! What sensors would have given of a simulated run.

use super::run::ScenarioRun;
use bracketry_symbolic::closest_name;
use bracketry_system::System;
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// A sensor that a model does not admit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorError {
    /// Neither an output nor a state.
    #[error("`{name}` is neither an output nor a state of the model: {remedy}")]
    UnknownName {
        /// The name as given.
        name: String,
        /// What to write instead.
        remedy: String,
    },
    /// No standard deviation.
    #[error("the noise of `{name}`, {std}, is not a standard deviation: give a number of at least 0")]
    BadDeviation {
        /// The output or state.
        name: String,
        /// What was given.
        std: f64,
    },
    /// Two sensors of one quantity.
    #[error("`{name}` is measured twice: remove one of them")]
    Twice {
        /// The output or state.
        name: String,
    },
}

impl ScenarioRun {
    /// Columns of a record of this run: the inputs as they are commanded, and each of `sensors` (an output or a state by name)
    /// with white Gaussian noise of the given standard deviation, in the unit of the quantity, at the times of the rows.
    /// The same seed gives the same noise. With `times` they make a record for the
    /// diagnosis.
    ///
    /// # Errors
    /// [`SensorError`] for a name that the model does not have and for a number that is no standard deviation.
    pub fn measured(
        &self,
        system: &System,
        sensors: &[(String, f64)],
        seed: u64,
    ) -> Result<Vec<(String, Vec<f64>)>, SensorError> {
        let mut random = StdRng::seed_from_u64(seed);
        let inputs = system.input_names().into_iter().enumerate();
        let inputs = inputs.map(|(k, name)| (name, self.inputs.iter().map(|u| u[k]).collect::<Vec<f64>>()));
        // Nothing is known of an input of which only derivatives are given.
        let mut columns: Vec<(String, Vec<f64>)> =
            inputs.filter(|(_, values)| !values.iter().any(|v| v.is_nan())).collect();
        for (k, (name, std)) in sensors.iter().enumerate() {
            if !std.is_finite() || *std < 0.0 {
                return Err(SensorError::BadDeviation { name: name.clone(), std: *std });
            }
            if sensors[..k].iter().any(|(other, _)| other == name) {
                return Err(SensorError::Twice { name: name.clone() });
            }
            let mut values = self.quantity(system, name)?;
            for v in &mut values {
                let e: f64 = StandardNormal.sample(&mut random);
                *v += std * e;
            }
            columns.push((name.clone(), values));
        }
        Ok(columns)
    }

    /// An output or a state at the times of the rows.
    fn quantity(&self, system: &System, name: &str) -> Result<Vec<f64>, SensorError> {
        if let Some(k) = system.outputs.iter().position(|(output, _)| output == name) {
            return Ok(self.outputs.iter().map(|y| y[k]).collect());
        }
        if let Some(k) = system.state_index(name) {
            return Ok(self.states.iter().map(|x| x[k]).collect());
        }
        let known: Vec<String> = system.outputs.iter().map(|(n, _)| n.clone()).chain(system.state_names()).collect();
        let remedy = match closest_name(name, known.iter().map(String::as_str)) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("it has {}", known.join(", ")),
        };
        Err(SensorError::UnknownName { name: name.to_owned(), remedy })
    }
}
