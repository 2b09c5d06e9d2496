//! The object on the plate, whichever model it follows.

use bracketry_plate::{Friction, Terms, first_principles, published, reduced};
use bracketry_sim::{Hold, InputError, Inputs, Mode, Model, Outcome, Samples, Settings, Stepper};
use bracketry_system::System;

use super::area::AreaCarried;
use super::{Moving, PlateModel, PlateRunError, PlateSetup};

/// How object and plate touch at one time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Touch {
    /// Normal force per mass in m/s², where the model reckons with one of its own; NaN where it is not known.
    pub(super) load: Option<f64>,
    /// Share of the contact that sticks.
    pub(super) stick_fraction: f64,
    /// Gap in metres.
    pub(super) gap: f64,
    /// Tilt against the plate about its x axis, in radians.
    pub(super) lean: f64,
}

/// An object on a moving plate.
pub(super) trait Carried {
    fn time(&self) -> f64;
    /// `x, y, phi` and their rates.
    fn state(&self) -> [f64; 6];
    fn moving(&mut self) -> &mut Moving;
    /// Simulates to `t`; says what stopped it before.
    fn advance(&mut self, t: f64) -> Result<Option<String>, PlateRunError>;
    /// Sets the amplitude of the experiment's formula.
    fn set_amplitude(&mut self, amplitude: f64);
    /// Takes the smooth piece of a logged motion that begins at `t`.
    fn begin_piece(&mut self, t: f64) -> Result<(), PlateRunError>;
    /// Shifts the object along the plate's x axis and changes its rate.
    fn shift(&mut self, x: f64, vx: f64) -> Result<(), PlateRunError>;
    fn touch(&mut self) -> Touch;
    /// Whether the object lies flat on the plate.
    fn flat(&self) -> bool {
        true
    }
    /// Number of events so far, where the model tells it.
    fn events(&self) -> Option<usize>;
    /// Error of the energy balance, where the model tells it.
    fn energy_closure(&self) -> Option<f64> {
        None
    }
}

/// The object of a setup, at its start.
pub(super) fn carried(setup: &PlateSetup, moving: Moving) -> Result<Box<dyn Carried>, PlateRunError> {
    setup.object.validate()?;
    setup.friction.validate()?;
    let coulomb = |remedy| match setup.friction {
        Friction::Coulomb { mu } => Ok(mu),
        _ => Err(PlateRunError::Unsuited { model: setup.model.name(), cannot: "knows Coulomb friction only", remedy }),
    };
    let system = match setup.model {
        PlateModel::Area | PlateModel::Body => return Ok(Box::new(AreaCarried::new(setup, moving)?)),
        PlateModel::Published => {
            published(&setup.object.shape, coulomb("leave --friction away or take --model area")?)?
        }
        PlateModel::Point => first_principles(&setup.object, &setup.friction, Terms::default())?,
        PlateModel::Reduced => {
            reduced(&setup.object, coulomb("leave --friction away or take --model area")?, Terms::default())?
        }
    };
    Ok(Box::new(Equations::new(setup, system, moving)?))
}

/// A model in the form of differential equations with exact stick and slip.
struct Equations {
    model: PlateModel,
    system: System,
    moving: Moving,
    drive: Option<(String, String, f64, f64)>,
    settings: Settings,
    stepper: Stepper<Model>,
    events: usize,
}

impl Equations {
    fn new(setup: &PlateSetup, system: System, moving: Moving) -> Result<Self, PlateRunError> {
        let e = &setup.experiment;
        let drive = match moving {
            Moving::Formula(_) => Some((e.displacement.clone(), e.tilt.clone(), setup.from, e.period)),
            Moving::Logged(..) => None,
        };
        let settings = Settings::default();
        let model = Model::new(&system, &inputs(&system, &moving, drive.as_ref(), setup.from)?)?;
        let [x, y, phi] = setup.start;
        let stepper = Stepper::new(model, setup.from, &[x, y, phi, 0.0, 0.0, 0.0], &settings)?;
        Ok(Self { model: setup.model, system, moving, drive, settings, stepper, events: 0 })
    }
}

/// Inputs `X, theta` of a model: expressions, or samples of a logged motion's smooth piece from `t` on.
fn inputs(
    system: &System,
    moving: &Moving,
    drive: Option<&(String, String, f64, f64)>,
    t: f64,
) -> Result<Inputs, InputError> {
    match (moving, drive) {
        (Moving::Logged(motion, piece), _) => {
            let times = motion.knots(*piece, t);
            let at: Vec<_> = times.iter().map(|t| motion.within(*piece, *t)).collect();
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
        (Moving::Formula(_), Some((displacement, tilt, t0, period))) => Ok(Inputs::new()
            .expression("X", displacement)
            .expression("theta", tilt)
            .live("A", 1.0)
            .live("t0", *t0)
            .live("T", *period)),
        (Moving::Formula(_), None) => Ok(Inputs::new()),
    }
}

impl Carried for Equations {
    fn time(&self) -> f64 {
        self.stepper.time()
    }

    fn state(&self) -> [f64; 6] {
        let mut state = [0.0; 6];
        state.copy_from_slice(&self.stepper.state()[..6]);
        state
    }

    fn moving(&mut self) -> &mut Moving {
        &mut self.moving
    }

    fn advance(&mut self, t: f64) -> Result<Option<String>, PlateRunError> {
        if t <= self.stepper.time() {
            return Ok(None);
        }
        Ok(match self.stepper.advance(t) {
            Outcome::Finished => None,
            Outcome::Stopped { reason, t, .. } => Some(format!("stopped at t = {t:.6} s: {reason}")),
        })
    }

    fn set_amplitude(&mut self, amplitude: f64) {
        self.stepper.system_mut().set_live("A", amplitude);
        self.moving.set_amplitude(amplitude);
    }

    fn begin_piece(&mut self, t: f64) -> Result<(), PlateRunError> {
        self.moving.begin_piece(t);
        self.events += self.stepper.statistics().events;
        let model = Model::new(&self.system, &inputs(&self.system, &self.moving, self.drive.as_ref(), t)?)?;
        self.stepper = Stepper::new(model, self.stepper.time(), self.stepper.state(), &self.settings)?;
        Ok(())
    }

    fn shift(&mut self, x: f64, vx: f64) -> Result<(), PlateRunError> {
        let mut state = self.stepper.state().to_vec();
        state[0] += x;
        state[3] += vx;
        Ok(self.stepper.set_state(self.stepper.time(), &state)?)
    }

    fn touch(&mut self) -> Touch {
        let modes = self.stepper.modes();
        let sticking = modes.iter().filter(|m| **m == Mode::Sticking).count();
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
