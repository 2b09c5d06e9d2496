//! An object whose motion a model in the form of differential equations gives.

use super::interface::{DrivenObject, STATES};
use crate::PlateError;
use crate::motion::Drive;
use bracketry_sim::{Inputs, Model, Outcome, SimulationSettings, Stepper, Trajectory};
use bracketry_system::System;
use std::sync::Arc;

/// A plate model in the form of differential equations, with exact stick and slip.
#[derive(Clone)]
pub struct ModelObject {
    system: Arc<System>,
    settings: SimulationSettings,
    stepper: Stepper<Model>,
}

impl ModelObject {
    /// A model with the states [`STATES`], in this order, and inputs `X`, `theta`, at time 0 in `state`.
    ///
    /// # Errors
    /// [`PlateError::NoState`] for other states, [`PlateError`] if the model cannot be compiled.
    pub fn new(system: &System, state: [f64; 6], settings: &SimulationSettings) -> Result<Self, PlateError> {
        for (index, name) in STATES.into_iter().enumerate() {
            if system.state_index(name) != Some(index) {
                return Err(PlateError::NoState { name });
            }
        }
        let model = Model::new(system, &Inputs::new())?;
        let stepper = Stepper::new(model, 0.0, &state, settings)?;
        Ok(Self { system: Arc::new(system.clone()), settings: settings.clone(), stepper })
    }
}

impl DrivenObject for ModelObject {
    type Course = Trajectory;

    fn time(&self) -> f64 {
        self.stepper.time()
    }

    fn state(&self) -> [f64; 6] {
        let mut state = [0.0; 6];
        state.copy_from_slice(self.stepper.state());
        state
    }

    fn set_state(&mut self, t: f64, state: [f64; 6]) -> Result<(), PlateError> {
        Ok(self.stepper.set_state(t, &state)?)
    }

    fn drive(&mut self, drive: &Drive) -> Result<(), PlateError> {
        let model = Model::new(&self.system, &drive.inputs())?;
        self.stepper = Stepper::new(model, self.stepper.time(), self.stepper.state(), &self.settings)?;
        Ok(())
    }

    fn set_number(&mut self, name: &str, value: f64) -> bool {
        self.stepper.system_mut().set_live(name, value)
    }

    fn record(&mut self, t_end: f64) -> Result<(Trajectory, Outcome), PlateError> {
        Ok(self.stepper.record(t_end)?)
    }
}
