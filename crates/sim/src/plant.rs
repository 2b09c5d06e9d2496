//! A model in a control loop: inputs held constant from sample to sample.

use crate::{
    FrictionMode, InputError, Inputs, Model, Outcome, SimError, SimulationSettings, Statistics, Stepper, Trajectory,
};
use bracketry_system::System;

/// A [`System`] simulated from one control sample to the next with its inputs held constant, on exact stick and slip.
///
/// ```
/// use bracketry_sim::{ExactPlant, SimulationSettings};
/// use bracketry_system::System;
/// let text = r#"
///     states = ["x", "v"]
///     inputs = ["a"]
///     dynamics = { x = "v", v = "a - sign(v)" }
/// "#;
/// let system = System::parse("block.toml", text).unwrap();
/// let mut plant = ExactPlant::new(&system, &[0.0, 0.0], &SimulationSettings::default()).unwrap();
/// assert!(plant.hold(&[0.9], 0.01).unwrap().is_finished()); // too weak: it holds
/// assert_eq!(plant.state(), &[0.0, 0.0]);
/// assert!(plant.hold(&[3.0], 0.01).unwrap().is_finished()); // v' = 3 − 1
/// assert!((plant.state()[1] - 0.02).abs() < 1e-12);
/// ```
#[derive(Debug, Clone)]
pub struct ExactPlant {
    stepper: Stepper<Model>,
}

/// A plant that cannot be made or used so.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// The inputs do not fit.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The state or the settings do not fit.
    #[error(transparent)]
    Sim(#[from] SimError),
}

impl ExactPlant {
    /// A plant at time 0 in state `x0`, all inputs held.
    ///
    /// # Errors
    /// [`PlantError`] if the system cannot be compiled, or for a wrong state or settings.
    pub fn new(system: &System, x0: &[f64], settings: &SimulationSettings) -> Result<Self, PlantError> {
        Self::starting_at(system, 0.0, x0, settings)
    }

    /// As [`ExactPlant::new`], at time `t`.
    ///
    /// # Errors
    /// As [`ExactPlant::new`], and for a time that is not finite.
    pub fn starting_at(system: &System, t: f64, x0: &[f64], settings: &SimulationSettings) -> Result<Self, PlantError> {
        let model = Model::new(system, &Inputs::new())?;
        Ok(Self { stepper: Stepper::new(model, t, x0, settings)? })
    }

    /// Sets the values at which the inputs were held before the start (one value per input, in order; 0 unless they are set), which
    /// act until the delays of the model have passed.
    ///
    /// # Errors
    /// [`PlantError`] for a wrong number of inputs.
    pub fn set_past_inputs(&mut self, u: &[f64]) -> Result<(), PlantError> {
        Ok(self.stepper.system_mut().set_past_inputs(u)?)
    }

    /// Holds the inputs at `u` (one value per input, in order) for `dt` seconds.
    ///
    /// # Errors
    /// [`PlantError`] for a wrong number of inputs or a negative `dt`. A solution that ends is an [`Outcome`].
    pub fn hold(&mut self, u: &[f64], dt: f64) -> Result<Outcome, PlantError> {
        self.stepper.system_mut().set_inputs(u)?;
        let (from, to) = (self.stepper.time(), self.stepper.time() + dt);
        if !to.is_finite() || to < from {
            return Err(SimError::BadTimeSpan { from, to }.into());
        }
        Ok(self.stepper.advance(to))
    }

    /// Current time in seconds.
    pub fn time(&self) -> f64 {
        self.stepper.time()
    }

    /// The compiled equations, with the inputs that are held.
    pub fn model(&self) -> &Model {
        self.stepper.system()
    }

    /// Current state.
    pub fn state(&self) -> &[f64] {
        self.stepper.state()
    }

    /// Current modes, one per switching function.
    pub fn modes(&self) -> &[FrictionMode] {
        self.stepper.modes()
    }

    /// Puts the plant into another state; the modes follow from it.
    ///
    /// # Errors
    /// [`PlantError`] for a state of the wrong length.
    pub fn set_state(&mut self, x: &[f64]) -> Result<(), PlantError> {
        Ok(self.stepper.set_state(self.stepper.time(), x)?)
    }

    /// Records the motion from here on.
    pub fn start_recording(&mut self) {
        self.stepper.start_recording();
    }

    /// The motion since [`ExactPlant::start_recording`], with its modes, across all that was held and every state that was set.
    pub fn take_recording(&mut self) -> Trajectory {
        self.stepper.take_recording()
    }

    /// Work done so far.
    pub fn statistics(&self) -> Statistics {
        self.stepper.statistics()
    }
}
