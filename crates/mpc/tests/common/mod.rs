//! Plants and files that several tests use.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub)]

pub mod reports;

use bracketry_sim::{ExactPlant, Settings};
use bracketry_system::System;
use std::path::PathBuf;

/// A file of the repository's models.
pub fn model_path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../models").join(name)
}

/// Cart with an inverted pendulum, th = 0 up.
pub fn cart_pole() -> System {
    System::read(model_path("cart_pole.toml")).unwrap()
}

/// A system with set-valued friction.
pub fn exact_plant(system: &System, x0: &[f64]) -> ExactPlant {
    ExactPlant::new(system, x0, &Settings::default()).unwrap()
}
