//! Plants and files that several tests use.

pub(crate) mod noise;
pub(crate) mod reports;

use bracketry_sim::{ExactPlant, SimulationSettings};
use bracketry_system::System;
use nalgebra::DMatrix;
use std::path::PathBuf;

/// A file of the repository's models.
pub(crate) fn model_path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../models").join(name)
}

/// A matrix by its rows. (The macros of nalgebra would build it, and all that stands on it, once more for the tests.)
pub(crate) fn dense<const N: usize, const M: usize>(rows: [[f64; M]; N]) -> DMatrix<f64> {
    DMatrix::from_fn(N, M, |i, j| rows[i][j])
}

/// Cart with an inverted pendulum, th = 0 up.
pub(crate) fn cart_pole() -> System {
    System::read(model_path("cart_pole.toml")).unwrap()
}

/// Double integrator p'' = u.
pub(crate) fn double_integrator() -> System {
    let text = r#"
        states = ["p", "v"]
        inputs = ["u"]
        dynamics = { p = "v", v = "u" }
    "#;
    System::parse("double_integrator.toml", text).unwrap()
}

/// A system with set-valued friction.
pub(crate) fn exact_plant(system: &System, x0: &[f64]) -> ExactPlant {
    ExactPlant::new(system, x0, &SimulationSettings::default()).unwrap()
}
