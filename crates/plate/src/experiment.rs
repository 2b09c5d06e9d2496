//! The three published open-loop experiments, with the amplitude held over each period.

use crate::plant::{crossing, least_load};
use crate::{Course, Drive, ExpressionMotion, ModelPlant, Plant, PlateError, PlateMotion, STATES};
use bracketry_sim::{Inputs, Outcome, Settings, Trajectory};
use bracketry_system::System;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Share of the way that counts as reached.
const REACHED: f64 = 0.98;

/// Amplitude of a period from the error `e = q − q_desired` at its start: `sgn(e)(offset + gain·|e|)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AmplitudeLaw {
    /// Amplitude at vanishing error.
    pub offset: f64,
    /// Amplitude per error.
    pub gain: f64,
}

/// What happens at the start of a period, where a new amplitude makes the displacement and its rate jump by `ΔX`, `ΔX'`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AmplitudeStep {
    /// The plate jumps under the object, which no bounded force can move in no time: `x` falls by `ΔX`, `x'` by `ΔX'`.
    #[default]
    WorldFixed,
    /// The plate goes on without the jump: only `X''` between the changes acts.
    Smooth,
}

/// An open-loop experiment: inputs in time with an amplitude `A` that is held over each period.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// What it is called.
    pub name: String,
    /// The state it moves: `x`, `y` or `phi`.
    pub coordinate: &'static str,
    /// Start of that state (m, rad).
    pub start: f64,
    /// Where it should go (m, rad).
    pub target: f64,
    /// Period `T` in seconds after which the amplitude is set anew.
    pub period: f64,
    /// `X(t)` in metres, an expression in `t`, its start `t0`, the period `T` and `A`.
    pub displacement: String,
    /// `theta(t)` in radians, an expression in `t`, its start `t0`, the period `T` and `A`.
    pub tilt: String,
    /// How the amplitude follows the error; absent if it is constant, `A = 1`.
    pub law: Option<AmplitudeLaw>,
    /// What happens where the amplitude changes.
    pub step: AmplitudeStep,
}

impl Experiment {
    /// Experiment 1, orientation 0 → 90°: `X = 0.025 sin(4πt) ξ`, `θ = −15° sin(4πt) ξ`, `ξ = 1 − exp(−t)`.
    pub fn orientation() -> Self {
        Self {
            name: "1, orientation".into(),
            coordinate: "phi",
            start: 0.0,
            target: 0.5 * PI,
            period: 0.5,
            displacement: "A*0.025*sin(2*pi*(t - t0)/T)*(1 - exp(t0 - t))".into(),
            tilt: "-A*15*pi/180*sin(2*pi*(t - t0)/T)*(1 - exp(t0 - t))".into(),
            law: None,
            step: AmplitudeStep::default(),
        }
    }

    /// Experiment 2, x 0.48 → 0.54 m: `X = A (0.51 − 0.5 cos 2ωt − 0.1 cos 4ωt) ξ`, `A = sgn(e)(0.015 + 0.3|e|)`, for
    /// `ω = omega_over_pi · π`. The period is `π/ω`.
    pub fn translation_x(omega_over_pi: u32) -> Self {
        Self {
            name: format!("2, x with ω = {omega_over_pi}π"),
            coordinate: "x",
            start: 0.48,
            target: 0.54,
            period: 1.0 / f64::from(omega_over_pi),
            displacement: "A*(0.51 - 0.5*cos(2*pi*(t - t0)/T) - 0.1*cos(4*pi*(t - t0)/T))*(1 - exp(t0 - t))".into(),
            tilt: "0".into(),
            law: Some(AmplitudeLaw { offset: 0.015, gain: 0.3 }),
            step: AmplitudeStep::default(),
        }
    }

    /// Experiment 3, y −0.03 → 0 m: `θ = A (1 − cos 6πt)/2 ξ`, `A = sgn(e)(20 + 200|e|)` degrees.
    pub fn translation_y() -> Self {
        let degree = PI / 180.0;
        Self {
            name: "3, y".into(),
            coordinate: "y",
            start: -0.03,
            target: 0.0,
            period: 1.0 / 3.0,
            displacement: "0".into(),
            tilt: "A*(1 - cos(2*pi*(t - t0)/T))/2*(1 - exp(t0 - t))".into(),
            law: Some(AmplitudeLaw { offset: 20.0 * degree, gain: 200.0 * degree }),
            step: AmplitudeStep::default(),
        }
    }

    /// The same with the sign of the error turned round, `e = q_desired − q`; nothing changes without an amplitude law.
    #[must_use]
    pub fn with_reversed_error(mut self) -> Self {
        if let Some(law) = &mut self.law {
            *law = AmplitudeLaw { offset: -law.offset, gain: -law.gain };
        }
        self
    }

    /// The same with the tilt to the other side. The torque of the published model turns experiment 1 clockwise, to
    /// −90°; with the tilt turned round the same model turns to +90°.
    #[must_use]
    pub fn with_reversed_tilt(mut self) -> Self {
        self.tilt = format!("-({})", self.tilt);
        self
    }

    /// The same with another treatment of the jump where the amplitude changes.
    #[must_use]
    pub fn with_amplitude_step(mut self, step: AmplitudeStep) -> Self {
        self.step = step;
        self
    }

    /// The same at another frequency in Hz; the swelling `ξ` keeps its second.
    #[must_use]
    pub fn with_frequency(mut self, frequency: f64) -> Self {
        self.period = 1.0 / frequency;
        self
    }

    /// The same with the displacement `factor` times as large.
    #[must_use]
    pub fn with_displacement_factor(mut self, factor: f64) -> Self {
        self.displacement = format!("({factor})*({})", self.displacement);
        self
    }

    /// The same with the tilt `factor` times as large.
    #[must_use]
    pub fn with_tilt_factor(mut self, factor: f64) -> Self {
        self.tilt = format!("({factor})*({})", self.tilt);
        self
    }

    /// The motion of the plate beginning at time `start`, with the amplitude as the number `A`.
    pub fn drive(&self, start: f64) -> Drive {
        let numbers = [("A", 1.0), ("t0", start), ("T", self.period)].map(|(name, value)| (name.to_owned(), value));
        Drive { displacement: self.displacement.clone(), tilt: self.tilt.clone(), numbers: numbers.to_vec() }
    }

    /// The same as inputs of a model.
    pub fn inputs(&self, start: f64) -> Inputs {
        self.drive(start).inputs()
    }

    /// The same as a compiled motion.
    ///
    /// # Errors
    /// [`PlateError::Motion`] if an expression cannot be read.
    pub fn motion(&self, start: f64) -> Result<ExpressionMotion, PlateError> {
        self.drive(start).motion()
    }

    /// Amplitude for the error `e = q − q_desired`.
    pub fn amplitude(&self, e: f64) -> f64 {
        match self.law {
            None => 1.0,
            Some(_) if e == 0.0 => 0.0,
            Some(law) => e.signum() * (law.offset + law.gain * e.abs()),
        }
    }

    /// Runs the experiment on a model in the form of differential equations from the state `x0`; see
    /// [`Experiment::run_on`].
    ///
    /// # Errors
    /// [`PlateError`] if the model does not fit.
    pub fn run(&self, system: &System, x0: &[f64], duration: f64, settings: &Settings) -> Result<Run, PlateError> {
        self.run_on(&mut ModelPlant::new(system, six(x0)?, settings)?, duration)
    }

    /// Runs the experiment for `duration` seconds on any plant, from the state and time at which it stands.
    ///
    /// The amplitude is read at the start of each period and held; [`AmplitudeStep`] says what happens where it changes. An
    /// object that rests on the plate at the start is taken along by the rate that the motion begins with.
    ///
    /// # Errors
    /// [`PlateError`] if the experiment does not fit the plant.
    pub fn run_on<P: Plant>(&self, plant: &mut P, duration: f64) -> Result<Run<P::Course>, PlateError> {
        self.run_until(plant, duration, |_, _| false)
    }

    /// The same, ended at the end of a period after which `ends(t, state)` holds.
    ///
    /// # Errors
    /// [`PlateError`] if the experiment does not fit the plant.
    pub fn run_until<P: Plant>(
        &self,
        plant: &mut P,
        duration: f64,
        mut ends: impl FnMut(f64, &[f64; 6]) -> bool,
    ) -> Result<Run<P::Course>, PlateError> {
        let mut held = HeldAmplitude::begin(self, plant)?;
        let (from, index) = (plant.time(), self.index()?);
        let (mut trajectory, mut outcome) = plant.record(from)?;
        let level = self.start + REACHED * (self.target - self.start);
        let way = (self.target - self.start).signum();
        let (mut amplitudes, mut reached, mut least_load) = (Vec::new(), None, f64::INFINITY);
        let mut period = 0u32;
        while outcome.is_finished() && plant.time() - from < duration {
            amplitudes.push((plant.time(), held.renew(plant)?));
            period += 1;
            let end = from + (f64::from(period) * self.period).min(duration);
            let (piece, ended) = plant.record(end)?;
            reached = reached.or_else(|| crossing(&piece, index, level, way));
            least_load = least_load.min(held.least_load(&piece));
            trajectory.join(&piece);
            outcome = ended;
            if ends(plant.time(), &plant.state()) {
                break;
            }
        }
        Ok(Run { trajectory, outcome, amplitudes, reached, least_load, coordinate: index, target: self.target })
    }

    /// Index of the coordinate among the states.
    pub(crate) fn index(&self) -> Result<usize, PlateError> {
        STATES[..3]
            .iter()
            .position(|name| *name == self.coordinate)
            .ok_or(PlateError::NoState { name: self.coordinate })
    }
}

/// The amplitude of an experiment on a plant, from period to period.
pub(crate) struct HeldAmplitude<'a> {
    experiment: &'a Experiment,
    index: usize,
    motion: ExpressionMotion,
    amplitude: Option<f64>,
}

impl<'a> HeldAmplitude<'a> {
    /// Begins the experiment's motion at the time of the plant.
    pub(crate) fn begin<P: Plant>(experiment: &'a Experiment, plant: &mut P) -> Result<Self, PlateError> {
        if !(experiment.period.is_finite() && experiment.period > 0.0) {
            return Err(PlateError::BadNumber { name: "period", value: experiment.period });
        }
        let index = experiment.index()?;
        plant.drive(&experiment.drive(plant.time()))?;
        Ok(Self { experiment, index, motion: experiment.motion(plant.time())?, amplitude: None })
    }

    /// Sets the amplitude for the period that begins now and returns it.
    pub(crate) fn renew<P: Plant>(&mut self, plant: &mut P) -> Result<f64, PlateError> {
        let (t, mut state) = (plant.time(), plant.state());
        let amplitude = self.experiment.amplitude(state[self.index] - self.experiment.target);
        let changed = self.amplitude.filter(|before| *before != amplitude);
        if let (AmplitudeStep::WorldFixed, Some(before)) = (self.experiment.step, changed) {
            self.motion.set("A", before);
            let old = self.motion.at(t);
            self.motion.set("A", amplitude);
            let new = self.motion.at(t);
            let jump = [old.displacement - new.displacement, old.velocity - new.velocity];
            if jump != [0.0; 2] {
                state[0] += jump[0];
                state[3] += jump[1];
                plant.set_state(t, state)?;
            }
        }
        plant.set_number("A", amplitude);
        self.motion.set("A", amplitude);
        self.amplitude = Some(amplitude);
        Ok(amplitude)
    }

    /// The least normal load over a course of this period.
    fn least_load<C: Course>(&mut self, course: &C) -> f64 {
        least_load(course, &mut self.motion, 0.0)
    }
}

/// The six states of a plant.
pub(crate) fn six(x: &[f64]) -> Result<[f64; 6], PlateError> {
    x.try_into()
        .map_err(|_| bracketry_sim::SimError::WrongLength { what: "the state", expected: 6, found: x.len() }.into())
}

/// What an experiment did.
#[derive(Debug, Clone)]
pub struct Run<C = Trajectory> {
    /// States at any time.
    pub trajectory: C,
    /// How the simulation ended.
    pub outcome: Outcome,
    /// Start and amplitude of each period.
    pub amplitudes: Vec<(f64, f64)>,
    /// First time at which 98 % of the way was covered, in seconds.
    pub reached: Option<f64>,
    /// Least normal load per mass in m/s² met on the way, without thickness; see [`normal_load`](crate::normal_load). Where
    /// it is negative, the object lifts off in truth, whatever a model without flight says.
    pub least_load: f64,
    coordinate: usize,
    target: f64,
}

impl<C: Course> Run<C> {
    /// Index of the moved coordinate among the states.
    pub fn coordinate(&self) -> usize {
        self.coordinate
    }

    /// Error of the coordinate at the end, `q − q_desired`.
    pub fn final_error(&self) -> f64 {
        self.trajectory.state_at(self.trajectory.end())[self.coordinate] - self.target
    }

    /// Least and greatest value of the coordinate from `from` to the end, sampled every millisecond.
    pub fn range(&self, from: f64) -> (f64, f64) {
        let end = self.trajectory.end();
        let samples = ((end - from) / 1e-3).max(0.0).floor() as usize;
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..=samples {
            let q = self.trajectory.state_at(from + 1e-3 * i as f64)[self.coordinate];
            range = (range.0.min(q), range.1.max(q));
        }
        range
    }
}
