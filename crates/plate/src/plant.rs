//! Whatever moves an object on an imposed plate motion: what experiments, sweeps and velocity fields run on.

use crate::{ExpressionMotion, PlateError, PlateKinematics, PlateMotion};
use bracketry_sim::{Inputs, Model, Outcome, Settings, Stepper, Trajectory};
use bracketry_system::System;
use std::sync::Arc;

/// Acceleration of gravity in m/s², as in the model files.
pub const GRAVITY: f64 = 9.81;

/// The states of every plant: position of the centre of mass in the plate frame (m), yaw (rad), and their rates.
pub const STATES: [&str; 6] = ["x", "y", "phi", "vx", "vy", "w"];

/// The motion of the plate as text: displacement `X` (m) and tilt `theta` (rad) as expressions of the time `t` and of
/// named numbers that can be changed while the plate moves.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// `X(t)` in metres.
    pub displacement: String,
    /// `theta(t)` in radians.
    pub tilt: String,
    /// The named numbers with their values at first.
    pub numbers: Vec<(String, f64)>,
}

impl Drive {
    /// A plate that stays level and at its place.
    pub fn still() -> Self {
        Self { displacement: "0".into(), tilt: "0".into(), numbers: Vec::new() }
    }

    /// The motion with its derivatives, compiled.
    ///
    /// # Errors
    /// [`PlateError::Motion`] if an expression cannot be read.
    pub fn motion(&self) -> Result<ExpressionMotion, PlateError> {
        let numbers: Vec<(&str, f64)> = self.numbers.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        ExpressionMotion::new(&self.displacement, &self.tilt, &numbers)
    }

    /// The motion as inputs `X`, `theta` of a model.
    pub fn inputs(&self) -> Inputs {
        let inputs = Inputs::new().expression("X", &self.displacement).expression("theta", &self.tilt);
        self.numbers.iter().fold(inputs, |inputs, (name, value)| inputs.live(name, *value))
    }
}

/// An object on a moving plate, with states [`STATES`].
pub trait Plant: Clone {
    /// States at any time of a recorded span.
    type Course: Course;

    /// Current time in seconds.
    fn time(&self) -> f64;

    /// Current state.
    fn state(&self) -> [f64; 6];

    /// Puts the object into another state at another time.
    ///
    /// # Errors
    /// [`PlateError`] if time or state are not finite.
    fn set_state(&mut self, t: f64, state: [f64; 6]) -> Result<(), PlateError>;

    /// Moves the plate otherwise from now on. At the beginning it stays still. A jump of the displacement or of its rate
    /// gives the object no impulse.
    ///
    /// # Errors
    /// [`PlateError`] if the motion does not fit.
    fn drive(&mut self, drive: &Drive) -> Result<(), PlateError>;

    /// Sets one of the motion's named numbers; false if there is none of that name.
    fn set_number(&mut self, name: &str, value: f64) -> bool;

    /// Simulates to `t_end` and records the way.
    ///
    /// # Errors
    /// [`PlateError`] if `t_end` is not finite or lies in the past. A simulation that ends early is an [`Outcome`].
    fn record(&mut self, t_end: f64) -> Result<(Self::Course, Outcome), PlateError>;
}

/// The states of a plant over a span of time.
pub trait Course: Clone {
    /// First time in seconds.
    fn start(&self) -> f64;

    /// Last time in seconds.
    fn end(&self) -> f64;

    /// The state at `t`; outside the span, the first or the last.
    fn state_at(&self, t: f64) -> [f64; 6];

    /// Joins a later course that begins where this one ends.
    fn join(&mut self, later: &Self);
}

impl Course for Trajectory {
    fn start(&self) -> f64 {
        self.start()
    }

    fn end(&self) -> f64 {
        self.end()
    }

    fn state_at(&self, t: f64) -> [f64; 6] {
        let mut state = [0.0; 6];
        self.sample_into(t, &mut state);
        state
    }

    fn join(&mut self, later: &Self) {
        self.append(later);
    }
}

/// A plate model in the form of differential equations, with exact stick and slip.
#[derive(Clone)]
pub struct ModelPlant {
    system: Arc<System>,
    settings: Settings,
    stepper: Stepper<Model>,
}

impl ModelPlant {
    /// A model with the states [`STATES`], in this order, and inputs `X`, `theta`, at time 0 in `state`.
    ///
    /// # Errors
    /// [`PlateError::NoState`] for other states, [`PlateError`] if the model cannot be compiled.
    pub fn new(system: &System, state: [f64; 6], settings: &Settings) -> Result<Self, PlateError> {
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

impl Plant for ModelPlant {
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

/// Normal load per mass in m/s² on an object whose centre of mass is `height` above the plate, `g cos θ + y θ'' + 2 y' θ' −
/// h θ'²`: where it is negative, the object lifts off and models without flight say
/// nothing.
pub fn normal_load(state: &[f64; 6], plate: &PlateKinematics, height: f64) -> f64 {
    GRAVITY * plate.tilt.cos() + state[1] * plate.tilt_acceleration + 2.0 * state[4] * plate.tilt_rate
        - height * plate.tilt_rate.powi(2)
}

/// The least normal load over a course, looked at [`PARTS`] times.
pub(crate) fn least_load<C: Course, M: PlateMotion>(course: &C, motion: &mut M, height: f64) -> f64 {
    let (start, length) = (course.start(), course.end() - course.start());
    (0..=PARTS)
        .map(|part| {
            let t = start + length * f64::from(part) / f64::from(PARTS);
            normal_load(&course.state_at(t), &motion.at(t), height)
        })
        .fold(f64::INFINITY, f64::min)
}

/// Parts of a course in which a rate is taken to change its sign once at most.
const PARTS: u32 = 64;

/// First time, to 1 ns, at which coordinate `index` has gone `way·(q − level) ≥ 0`. Where it turns back close to the
/// level, the turn is looked at, so that no crossing between two samples is missed.
pub(crate) fn crossing<C: Course>(course: &C, index: usize, level: f64, way: f64) -> Option<f64> {
    let beyond = |t: f64| way * (course.state_at(t)[index] - level) >= 0.0;
    let approaches = |t: f64| way * course.state_at(t)[index + 3] > 0.0;
    let (start, end) = (course.start(), course.end());
    let mut before = start;
    if beyond(before) {
        return Some(before);
    }
    for part in 1..=PARTS {
        let at = if part == PARTS { end } else { start + (end - start) * f64::from(part) / f64::from(PARTS) };
        let turn = (approaches(before) && !approaches(at)).then(|| bisect(before, at, |t| !approaches(t)));
        for at in turn.into_iter().chain([at]) {
            if beyond(at) {
                return Some(bisect(before, at, beyond));
            }
        }
        before = at;
    }
    None
}

/// The end of the interval from `a` (false) to `b` (true) at which a condition becomes true, to 1 ns.
fn bisect(mut a: f64, mut b: f64, condition: impl Fn(f64) -> bool) -> f64 {
    while b - a > 1e-9 {
        let m = 0.5 * (a + b);
        if condition(m) { b = m } else { a = m }
    }
    b
}
