//! The three published open-loop experiments, with the amplitude held over each period.

use crate::{ExpressionMotion, PlateError};
use bracketry_sim::{Inputs, Model, Outcome, Settings, Stepper, Trajectory};
use bracketry_system::System;
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
    /// Period in seconds after which the amplitude is set anew.
    pub period: f64,
    /// `X(t)` in metres, an expression in `t`, its start `t0` and `A`.
    pub displacement: String,
    /// `theta(t)` in radians, an expression in `t`, its start `t0` and `A`.
    pub tilt: String,
    /// How the amplitude follows the error; absent if it is constant, `A = 1`.
    pub law: Option<AmplitudeLaw>,
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
            displacement: "A*0.025*sin(4*pi*(t - t0))*(1 - exp(t0 - t))".into(),
            tilt: "-A*15*pi/180*sin(4*pi*(t - t0))*(1 - exp(t0 - t))".into(),
            law: None,
        }
    }

    /// Experiment 2, x 0.48 → 0.54 m: `X = A (0.51 − 0.5 cos 2ωt − 0.1 cos 4ωt) ξ`, `A = sgn(e)(0.015 + 0.3|e|)`, for
    /// `ω = omega_over_pi · π`. The period is `π/ω`.
    pub fn translation_x(omega_over_pi: u32) -> Self {
        let twice = 2 * omega_over_pi;
        Self {
            name: format!("2, x with ω = {omega_over_pi}π"),
            coordinate: "x",
            start: 0.48,
            target: 0.54,
            period: 1.0 / f64::from(omega_over_pi),
            displacement: format!(
                "A*(0.51 - 0.5*cos({twice}*pi*(t - t0)) - 0.1*cos({}*pi*(t - t0)))*(1 - exp(t0 - t))",
                2 * twice
            ),
            tilt: "0".into(),
            law: Some(AmplitudeLaw { offset: 0.015, gain: 0.3 }),
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
            tilt: "A*(1 - cos(6*pi*(t - t0)))/2*(1 - exp(t0 - t))".into(),
            law: Some(AmplitudeLaw { offset: 20.0 * degree, gain: 200.0 * degree }),
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

    /// The inputs beginning at time `start`, with the live numbers `A` and `t0`.
    pub fn inputs(&self, start: f64) -> Inputs {
        Inputs::new()
            .expression("X", &self.displacement)
            .expression("theta", &self.tilt)
            .live("A", 1.0)
            .live("t0", start)
    }

    /// The plate's motion beginning at time `start`, with the numbers `A` (1 until it is set) and `t0`.
    ///
    /// # Errors
    /// [`PlateError::Motion`] if an expression cannot be read.
    pub fn motion(&self, start: f64) -> Result<ExpressionMotion, PlateError> {
        ExpressionMotion::new(&self.displacement, &self.tilt, &[("A", 1.0), ("t0", start)])
    }

    /// Amplitude for the error `e = q − q_desired`.
    pub fn amplitude(&self, e: f64) -> f64 {
        match self.law {
            None => 1.0,
            Some(_) if e == 0.0 => 0.0,
            Some(law) => e.signum() * (law.offset + law.gain * e.abs()),
        }
    }

    /// Runs the experiment on a model with inputs `X`, `theta` and the coordinate among its states, from the state `x0`.
    ///
    /// The amplitude is read at the start of each period and held. Where it changes, `X` would jump; the plate is taken to
    /// go on without the jump: only `X''` between the changes acts.
    ///
    /// # Errors
    /// [`PlateError`] if the model does not fit.
    pub fn run(&self, system: &System, x0: &[f64], duration: f64, settings: &Settings) -> Result<Run, PlateError> {
        let index = self.index(system)?;
        let model = Model::new(system, &self.inputs(0.0))?;
        let mut stepper = Stepper::new(model, 0.0, x0, settings)?;
        let (mut trajectory, mut outcome) = stepper.record(0.0)?;
        let mut amplitudes = Vec::new();
        let mut period = 0u32;
        while outcome.is_finished() && stepper.time() < duration {
            let amplitude = self.amplitude(stepper.state()[index] - self.target);
            amplitudes.push((stepper.time(), amplitude));
            stepper.system_mut().set_live("A", amplitude);
            period += 1;
            let end = (f64::from(period) * self.period).min(duration);
            let (piece, ended) = stepper.record(end)?;
            trajectory.append(&piece);
            outcome = ended;
        }
        let reached = first_reaching(&trajectory, index, self.start, self.target);
        Ok(Run { trajectory, outcome, amplitudes, reached, coordinate: index, target: self.target })
    }

    /// Index of the coordinate among the states.
    pub(crate) fn index(&self, system: &System) -> Result<usize, PlateError> {
        system.state_index(self.coordinate).ok_or(PlateError::NoState { name: self.coordinate })
    }
}

/// First time at which 98 % of the way from `start` to `target` is covered, to 1 µs.
fn first_reaching(trajectory: &Trajectory, index: usize, start: f64, target: f64) -> Option<f64> {
    let covered = |t: f64| (trajectory.sample(t)[index] - start) / (target - start) >= REACHED;
    let mut before = trajectory.start();
    for t in trajectory.times() {
        // Steps are short against the motion, but their ends need not see every turn.
        for part in 1..=4 {
            let at = before + (t - before) * f64::from(part) / 4.0;
            if covered(at) {
                let (mut a, mut b) = (before, at);
                while b - a > 1e-6 {
                    let m = 0.5 * (a + b);
                    if covered(m) { b = m } else { a = m }
                }
                return Some(b);
            }
        }
        before = t;
    }
    None
}

/// What an experiment did.
#[derive(Debug, Clone)]
pub struct Run {
    /// States at any time.
    pub trajectory: Trajectory,
    /// How the simulation ended.
    pub outcome: Outcome,
    /// Start and amplitude of each period.
    pub amplitudes: Vec<(f64, f64)>,
    /// First time at which 98 % of the way was covered, in seconds.
    pub reached: Option<f64>,
    coordinate: usize,
    target: f64,
}

impl Run {
    /// Index of the moved coordinate among the states.
    pub fn coordinate(&self) -> usize {
        self.coordinate
    }

    /// Error of the coordinate at the end, `q − q_desired`.
    pub fn final_error(&self) -> f64 {
        self.trajectory.final_state()[self.coordinate] - self.target
    }

    /// Least and greatest value of the coordinate from `from` to the end, sampled every millisecond.
    pub fn range(&self, from: f64) -> (f64, f64) {
        let end = self.trajectory.end();
        let samples = ((end - from) / 1e-3).max(0.0).floor() as usize;
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..=samples {
            let q = self.trajectory.sample(from + 1e-3 * i as f64)[self.coordinate];
            range = (range.0.min(q), range.1.max(q));
        }
        range
    }
}
