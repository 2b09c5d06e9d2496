//! The thing that is controlled.

use crate::dynamics::Dynamics;
use crate::error::PlantError;
use crate::integrator::{Integrator, Interval};
use crate::transcription::Shooter;

/// The thing that is controlled.
pub trait Plant {
    /// Advances the state `x` from time `t` by `dt` under constant inputs `u`.
    ///
    /// # Errors
    /// Whatever stops the plant.
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError>;
}

/// A plant with the dynamics of a model, integrated by the classical Runge–Kutta method.
pub struct RungeKuttaPlant {
    dynamics: Box<dyn Dynamics>,
    shooter: Shooter,
    substeps: usize,
}

impl RungeKuttaPlant {
    /// A plant with `substeps` integration steps per call.
    pub fn new(dynamics: Box<dyn Dynamics>, substeps: usize) -> Self {
        Self { shooter: Shooter::new(dynamics.as_ref(), Integrator::Rk4), dynamics, substeps: substeps.max(1) }
    }
}

impl Plant for RungeKuttaPlant {
    fn step(&mut self, t: f64, x: &mut [f64], u: &[f64], dt: f64) -> Result<(), PlantError> {
        self.shooter.advance(self.dynamics.as_mut(), Interval { t, dt, substeps: self.substeps, u }, x);
        Ok(())
    }
}
