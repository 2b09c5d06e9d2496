//! The three published open-loop experiments, with the amplitude held over each period.

use crate::motion::{Drive, ExpressionMotion};
use crate::{PlateError, PlateMotion, STATES};
use bracketry_sim::Inputs;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Share of the distance to the target that counts as reached.
pub(crate) const REACHED: f64 = 0.98;

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

/// A coordinate of the object on the plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinate {
    /// Along the motion of the plate, m.
    X,
    /// Across, m.
    Y,
    /// Yaw, rad.
    Phi,
}

impl Coordinate {
    /// Its name, which is that of the state.
    pub fn name(self) -> &'static str {
        STATES[self as usize]
    }
}

/// An open-loop experiment: inputs in time with an amplitude `A` that is held over each period.
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment {
    /// What it is called.
    pub name: String,
    /// The state it moves.
    pub coordinate: Coordinate,
    /// Start of that state (m, rad).
    pub start: f64,
    /// Where it should go (m, rad).
    pub target: f64,
    /// Period `T` in seconds after which the amplitude is set anew.
    pub period: f64,
    /// `X(t)` in meters, an expression in `t`, its start `t0`, the period `T` and `A`.
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
            coordinate: Coordinate::Phi,
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
            coordinate: Coordinate::X,
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
            coordinate: Coordinate::Y,
            start: -0.03,
            target: 0.0,
            period: 1.0 / 3.0,
            displacement: "0".into(),
            tilt: "A*(1 - cos(2*pi*(t - t0)/T))/2*(1 - exp(t0 - t))".into(),
            law: Some(AmplitudeLaw { offset: 20.0 * degree, gain: 200.0 * degree }),
            step: AmplitudeStep::default(),
        }
    }

    /// The same with the sign of the error flipped, `e = q_desired − q`; nothing changes without an amplitude law.
    #[must_use]
    pub fn with_reversed_error(mut self) -> Self {
        if let Some(law) = &mut self.law {
            *law = AmplitudeLaw { offset: -law.offset, gain: -law.gain };
        }
        self
    }

    /// The same with the tilt to the other side. The torque of the published model turns experiment 1 clockwise, to
    /// −90°; with the sign of the tilt flipped the same model turns to +90°.
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

    /// Whether the amplitude is that of the displacement, not of the tilt alone.
    ///
    /// # Errors
    /// [`PlateError::Motion`] if an expression cannot be read.
    pub(crate) fn scales_displacement(&self) -> Result<bool, PlateError> {
        let mut motion = self.motion(0.0)?;
        // A formula with the amplitude as a factor vanishes at single times only; these are no part of a period.
        let mut at = |amplitude: f64| {
            motion.set("A", amplitude);
            [0.31, 0.77].map(|part| motion.at(part * self.period).displacement)
        };
        Ok(at(0.0) != at(1.0))
    }

    /// Amplitude for the error `e = q − q_desired`.
    pub fn amplitude(&self, e: f64) -> f64 {
        match self.law {
            None => 1.0,
            Some(_) if e == 0.0 => 0.0,
            Some(law) => e.signum() * (law.offset + law.gain * e.abs()),
        }
    }

    /// Index of the coordinate among the states.
    pub fn index(&self) -> usize {
        self.coordinate as usize
    }
}
