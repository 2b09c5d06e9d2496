//! What is measured in a problem, and the estimator.

use crate::error::MpcError;
use crate::estimation::{
    DisturbanceChannel, EstimationProblem, Estimator, ExtendedKalman, MovingHorizon, MovingHorizonSettings,
};
use crate::ocp::VectorFunction;
use bracketry_symbolic::Rational;
use bracketry_system::{Parameter, System};
use rustc_hash::FxHashMap;

/// Which estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EstimatorKind {
    /// [`MovingHorizon`].
    MovingHorizon,
    /// [`ExtendedKalman`].
    ExtendedKalman,
}

/// What is measured in a problem, and what makes states of it.
#[derive(Clone)]
pub struct Estimation {
    /// Which estimator.
    pub kind: EstimatorKind,
    /// Sensors, noise, unknown parameters and disturbances.
    pub problem: EstimationProblem,
    /// Length of the horizon and number of programs per sample (moving horizon).
    pub settings: MovingHorizonSettings,
    /// Names of the measured outputs.
    pub names: Vec<String>,
}

impl Estimation {
    /// The estimator at time 0.
    ///
    /// # Errors
    /// If the estimation problem contradicts itself or the model.
    pub fn estimator(&self) -> Result<Box<dyn Estimator>, MpcError> {
        Ok(match self.kind {
            EstimatorKind::MovingHorizon => Box::new(MovingHorizon::new(&self.problem, self.settings)?),
            EstimatorKind::ExtendedKalman => Box::new(ExtendedKalman::new(&self.problem)?),
        })
    }

    /// What the sensors of a plant measure without noise, as a function of its state.
    ///
    /// # Errors
    /// If an output uses a name that the plant does not have.
    pub fn outputs(&self, plant: &System) -> Result<VectorFunction, MpcError> {
        let texts: Vec<&str> = self.problem.outputs.iter().map(|o| o.expression.as_str()).collect();
        VectorFunction::parse(plant, &[], &texts)
    }

    /// Whether anything but the state is estimated.
    pub(crate) fn hands_over(&self) -> bool {
        !self.problem.parameters.is_empty() || !self.problem.disturbances.is_empty()
    }

    /// The controller's model with the disturbances as parameters, and the names of all that the estimator hands over.
    pub(crate) fn disturbed(&self, system: &System) -> (System, Vec<String>) {
        let mut system = system.clone();
        let mut live: Vec<String> = self.problem.parameters.iter().map(|p| p.name.clone()).collect();
        for (k, d) in self.problem.disturbances.iter().enumerate() {
            let name = format!("disturbance#{k}");
            let symbol = system.pool.symbol(&name);
            let offset = system.pool.sym(symbol);
            match &d.channel {
                DisturbanceChannel::State(state) => {
                    if let Some(i) = system.state_index(state) {
                        system.dynamics[i] = system.pool.add(system.dynamics[i], offset);
                    }
                }
                DisturbanceChannel::Input(input) => {
                    if let Some(j) = system.input_index(input) {
                        let u = system.pool.sym(system.inputs[j]);
                        let sum = system.pool.add(u, offset);
                        let map: FxHashMap<_, _> = [(u, sum)].into_iter().collect();
                        system.dynamics = system.pool.substitute_all(&system.dynamics, &map);
                    }
                }
                DisturbanceChannel::Output(_) => {}
            }
            let value = Rational::default();
            system.parameters.push(Parameter { symbol, value, min: None, max: None, unit: None, about: None });
            live.push(name);
        }
        (system, live)
    }
}
