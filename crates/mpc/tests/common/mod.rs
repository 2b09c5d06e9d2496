//! Plants and files that several tests use.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub)]

use bracketry_mpc::{Plant, PlantError};
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
pub struct ExactPlant(pub bracketry_sim::Plant);

impl ExactPlant {
    pub fn new(system: &System, x0: &[f64]) -> Self {
        Self(bracketry_sim::Plant::new(system, x0, &bracketry_sim::Settings::default()).unwrap())
    }
}

impl Plant for ExactPlant {
    fn step(&mut self, _t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        if self.0.state() != x {
            self.0.set_state(x)?;
        }
        let outcome = self.0.step(u, dt)?;
        assert!(outcome.is_finished(), "{outcome:?}");
        x.copy_from_slice(self.0.state());
        Ok(())
    }
}
