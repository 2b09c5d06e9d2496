//! A model in the form of differential equations with exact stick and slip.

use bracketry_sim::{FrictionMode, Hold, InputError, Inputs, Model, Outcome, Samples, SimulationSettings, Stepper};
use bracketry_system::System;

use super::error::PlateRunError;
use super::imposed_motion::ImposedMotion;
use super::object_model::{ObjectModel, Touch};
use super::result::PlateStop;
use super::setup::{PlateModel, PlateSetup};
use crate::log::LoggedMotion;
use crate::motion::Drive;

#[derive(Clone)]
pub(super) struct Equations {
    model: PlateModel,
    system: System,
    motion: ImposedMotion,
    drive: Drive,
    settings: SimulationSettings,
    stepper: Stepper<Model>,
    events: usize,
}

impl Equations {
    pub(super) fn new(setup: &PlateSetup, system: System, motion: ImposedMotion) -> Result<Self, PlateRunError> {
        let drive = setup.experiment.drive(setup.from);
        let settings = SimulationSettings::default();
        let model = Model::new(&system, &inputs(&system, &motion, &drive, setup.from)?)?;
        let [x, y, phi] = setup.start;
        let stepper = Stepper::new(model, setup.from, &[x, y, phi, 0.0, 0.0, 0.0], &settings)?;
        Ok(Self { model: setup.model, system, motion, drive, settings, stepper, events: 0 })
    }
}

/// Inputs `X, theta` of a model: expressions, or samples of a logged motion's smooth piece from `t` on.
fn inputs(system: &System, motion: &ImposedMotion, drive: &Drive, t: f64) -> Result<Inputs, InputError> {
    match motion {
        ImposedMotion::Formula(_) => Ok(drive.inputs()),
        ImposedMotion::Logged(motion, piece) => sampled(system, motion, *piece, t),
    }
}

fn sampled(system: &System, motion: &LoggedMotion, piece: f64, t: f64) -> Result<Inputs, InputError> {
    let times = motion.knots(piece, t);
    let at: Vec<_> = times.iter().map(|t| motion.within(piece, *t)).collect();
    let samples = |values: Vec<f64>| Samples::new(times.clone(), values, Hold::Linear);
    let mut inputs = Inputs::new()
        .samples("X", samples(at.iter().map(|k| k.displacement).collect())?)
        .samples("theta", samples(at.iter().map(|k| k.tilt).collect())?);
    for d in &system.input_derivatives {
        let values = match (d.input, d.order) {
            (0, 1) => at.iter().map(|k| k.velocity).collect(),
            (0, _) => at.iter().map(|k| k.acceleration).collect(),
            (_, 1) => at.iter().map(|k| k.tilt_rate).collect(),
            (_, _) => at.iter().map(|k| k.tilt_acceleration).collect(),
        };
        let name = if d.input == 0 { "X" } else { "theta" };
        inputs = inputs.derivative(name, d.order, samples(values)?);
    }
    Ok(inputs)
}

impl ObjectModel for Equations {
    fn time(&self) -> f64 {
        self.stepper.time()
    }

    fn state(&self) -> [f64; 6] {
        let mut state = [0.0; 6];
        state.copy_from_slice(&self.stepper.state()[..6]);
        state
    }

    fn motion(&mut self) -> &mut ImposedMotion {
        &mut self.motion
    }

    fn advance(&mut self, t: f64) -> Result<Option<PlateStop>, PlateRunError> {
        if t <= self.stepper.time() {
            return Ok(None);
        }
        Ok(match self.stepper.advance(t) {
            Outcome::Finished => None,
            Outcome::Stopped { reason, t, .. } => Some(PlateStop::Integration { t, reason }),
        })
    }

    fn set_amplitude(&mut self, amplitude: f64) {
        self.stepper.system_mut().set_live("A", amplitude);
        self.motion.set_amplitude(amplitude);
    }

    fn start_piece(&mut self, t: f64) -> Result<(), PlateRunError> {
        self.motion.start_piece(t);
        self.events += self.stepper.statistics().events;
        let model = Model::new(&self.system, &inputs(&self.system, &self.motion, &self.drive, t)?)?;
        self.stepper = Stepper::new(model, self.stepper.time(), self.stepper.state(), &self.settings)?;
        Ok(())
    }

    fn shift(&mut self, x: f64, vx: f64) -> Result<(), PlateRunError> {
        let mut state = self.stepper.state().to_vec();
        state[0] += x;
        state[3] += vx;
        Ok(self.stepper.set_state(self.stepper.time(), &state)?)
    }

    fn fork(&self) -> Box<dyn ObjectModel> {
        Box::new(self.clone())
    }

    fn touch(&mut self) -> Touch {
        let modes = self.stepper.modes();
        let sticking = modes.iter().filter(|m| **m == FrictionMode::Sticking).count();
        // Coupled friction sticks where all components of the slip vanish; per-axis friction sticks along each axis.
        let stick_fraction = match self.model {
            PlateModel::Published => sticking as f64 / modes.len().max(1) as f64,
            _ => f64::from(u8::from(sticking == modes.len())),
        };
        Touch { stick_fraction, ..Touch::default() }
    }

    fn events(&self) -> Option<usize> {
        Some(self.events + self.stepper.statistics().events)
    }
}
