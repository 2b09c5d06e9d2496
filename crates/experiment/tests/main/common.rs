//! A model from text, and options for inputs `u` and outputs `y`.

use bracketry_experiment::{ExperimentOptions, Limit};
use bracketry_system::System;

pub(crate) fn model(text: &str) -> System {
    System::parse("model.toml", text).unwrap()
}

pub(crate) fn options(duration: f64) -> ExperimentOptions {
    ExperimentOptions {
        limits: vec![Limit::new("u", -1.0, 1.0)],
        noise: vec![("y".into(), 0.01)],
        starts: 3,
        ..ExperimentOptions::lasting(duration)
    }
}
