//! One trial: a controller against the area-contact plant.

use super::criterion::{REST, TrialSample, at_rest, pose_error, time_to_target};
use super::scenario::Trial;
use super::{Scenario, Tolerance};
use crate::TrialError;
use bracketry_plate::area::{AreaContact, AreaOutcome, AreaSettings};
use bracketry_plate::control::{Command, Measurement, PlateController, PlateLimits};
use bracketry_plate::recording::Random;
use bracketry_plate::{Friction, Object, PlateError, PlateKinematics};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::time::Instant;

/// What the trials of a series have in common.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialSetup {
    /// The object.
    pub object: Object,
    /// Settings of the plant.
    pub area: AreaSettings,
    /// Bounds of the plate's motion, which the controller has to keep; the plant obeys any command.
    pub limits: PlateLimits,
    /// How close to the target is close enough.
    pub tolerance: Tolerance,
    /// Longest time in s.
    pub duration: f64,
    /// How long a trial goes on in s once nothing moves any more: the controller has finished, plate and object rest, no push
    /// is to come.
    pub dwell: f64,
    /// Bandwidth in Hz of the plate's servo: its accelerations follow the commands with a first-order lag. Infinite for a plate that
    /// does what it is told.
    pub servo_bandwidth: f64,
    /// Age of a measured pose in s when the controller gets it, which it is not told.
    pub latency: f64,
}

impl TrialSetup {
    /// The setup of a scenario with an object: plant as by default (1 ms, 48 points), half a second of rest at the end, a plate that
    /// does what it is told, and a camera without latency.
    pub fn new(object: &Object, scenario: &Scenario) -> Self {
        Self {
            object: object.clone(),
            area: AreaSettings::default(),
            limits: scenario.limits,
            tolerance: scenario.tolerance(),
            duration: scenario.duration,
            dwell: 0.5,
            servo_bandwidth: f64::INFINITY,
            latency: 0.0,
        }
    }
}

/// How a trial ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrialOutcome {
    /// The object lies at its target, the plate rests.
    Reached {
        /// First time in s from which on that holds.
        time: f64,
    },
    /// It does not at the end.
    Missed {
        /// Whether the position is within the tolerance.
        position: bool,
        /// Whether the yaw is.
        angle: bool,
        /// Whether the plate rests.
        at_rest: bool,
    },
    /// The object starts to tip.
    Tipping {
        /// When, in s.
        time: f64,
    },
    /// The object lifts off.
    LiftOff {
        /// When, in s.
        time: f64,
    },
    /// State or motion of the plate left the range of floating-point numbers.
    NotFinite {
        /// When, in s.
        time: f64,
    },
    /// The controller gave no command that can be carried out.
    ControllerFailed {
        /// When, in s.
        time: f64,
        /// Why.
        reason: String,
    },
}

impl TrialOutcome {
    /// Time to target in s if it was reached.
    pub fn time(&self) -> Option<f64> {
        match self {
            Self::Reached { time } => Some(*time),
            _ => None,
        }
    }

    /// In a few words, the same for all trials that ended alike.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Reached { .. } => "reached",
            Self::Missed { at_rest: false, .. } => "plate still moving",
            Self::Missed { position: false, angle: false, .. } => "position and yaw error",
            Self::Missed { position: false, .. } => "position error",
            Self::Missed { .. } => "yaw error",
            Self::Tipping { .. } => "tipping",
            Self::LiftOff { .. } => "lift-off",
            Self::NotFinite { .. } => "not finite",
            Self::ControllerFailed { .. } => "controller failed",
        }
    }
}

/// A sampling instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlSample {
    /// Time in s.
    pub t: f64,
    /// What the controller saw.
    pub measurement: Measurement,
    /// What acts on the plate from now on for a period.
    pub acting: Command,
    /// Wall time of the controller in s.
    pub seconds: f64,
}

/// Peaks of the plate's motion, as shares of their bounds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Utilization {
    /// Of the stroke.
    pub stroke: f64,
    /// Of the tilt.
    pub tilt: f64,
    /// Of `|X''|`.
    pub displacement_acceleration: f64,
    /// Of `|θ''|`.
    pub tilt_acceleration: f64,
}

impl Utilization {
    fn of(samples: &[TrialSample], limits: &PlateLimits) -> Self {
        let peak = |value: fn(&PlateKinematics) -> f64, bound: f64| {
            samples.iter().map(|s| value(&s.plate).abs()).fold(0.0, f64::max) / bound
        };
        Self {
            stroke: peak(|p| p.displacement, limits.stroke),
            tilt: peak(|p| p.tilt, limits.tilt),
            displacement_acceleration: peak(|p| p.acceleration, limits.displacement_acceleration),
            tilt_acceleration: peak(|p| p.tilt_acceleration, limits.tilt_acceleration),
        }
    }

    /// The greatest share.
    pub fn greatest(&self) -> f64 {
        self.stroke.max(self.tilt).max(self.displacement_acceleration).max(self.tilt_acceleration)
    }

    /// Whether all bounds are kept, but for 0.1 % of them.
    pub fn keeps(&self) -> bool {
        self.greatest() <= 1.001
    }
}

/// A trial with all that happened.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialRun {
    /// Object and plate, at least every step of the plant.
    pub samples: Vec<TrialSample>,
    /// The sampling instants.
    pub controls: Vec<ControlSample>,
    /// How it ended.
    pub outcome: TrialOutcome,
    /// Error at the end, `x, y` (m), `phi` (rad, to the nearest whole turn).
    pub final_error: [f64; 3],
    /// How far the bounds were made use of.
    pub utilization: Utilization,
}

/// Runs a trial on the area-contact plant, the plate's motion integrated exactly from the commands or, with a
/// servo, from their lagged values.
///
/// # Errors
/// [`TrialError`] if trial or setup have no meaning. What goes wrong in the trial is its outcome.
pub fn run_trial<C: PlateController + ?Sized>(
    trial: &Trial,
    setup: &TrialSetup,
    controller: &mut C,
) -> Result<TrialRun, TrialError> {
    let mut simulation = Simulation::new(trial, setup, controller.period())?;
    let early = loop {
        if let Some(outcome) = simulation.period(controller)? {
            break Some(outcome);
        }
        if simulation.over() {
            break None;
        }
    };
    let Simulation { samples, controls, .. } = simulation;
    // The start is a sample.
    let end = samples[samples.len() - 1];
    let [x, y, phi, ..] = end.object;
    let final_error = pose_error([x, y, phi], trial.target);
    let missed = || {
        let [position, angle] = setup.tolerance.holds(final_error);
        TrialOutcome::Missed { position, angle, at_rest: at_rest(&end.plate) }
    };
    let outcome = early.unwrap_or_else(|| {
        let time = time_to_target(&samples, trial.target, setup.tolerance);
        time.map_or_else(missed, |time| TrialOutcome::Reached { time })
    });
    let utilization = Utilization::of(&samples, &setup.limits);
    Ok(TrialRun { samples, controls, outcome, final_error, utilization })
}

/// The servo of the plate: `T a' = u − a` for the commanded accelerations `u`, `T = 1/(2π bandwidth)`.
#[derive(Debug, Clone, Copy)]
struct Servo {
    time_constant: f64,
    /// The accelerations that it has reached: `X''` in m/s², `θ''` in rad/s².
    acceleration: [f64; 2],
}

impl Servo {
    fn new(bandwidth: f64) -> Self {
        Self { time_constant: 1.0 / (TAU * bandwidth), acceleration: [0.0; 2] }
    }

    /// Whether what is left of its acceleration moves nothing.
    fn at_rest(&self) -> bool {
        self.time_constant == 0.0 || self.acceleration.iter().all(|a| a.abs() * self.time_constant <= REST)
    }

    /// The plate after a time, from a motion whose accelerations are the commanded ones.
    fn after(&self, plate: &PlateKinematics, time: f64) -> PlateKinematics {
        let mut end = plate.after(time);
        if self.time_constant == 0.0 {
            return end;
        }
        let left = (-time / self.time_constant).exp();
        let add = |[rate, position, acceleration]: [&mut f64; 3], reached: f64| {
            let lag = reached - *acceleration;
            // Integrals of `lag · exp(−t/T)`.
            let gained = lag * self.time_constant * (1.0 - left);
            *position += self.time_constant * (lag * time - gained);
            *rate += gained;
            *acceleration += lag * left;
        };
        let PlateKinematics { displacement, velocity, acceleration, tilt, tilt_rate, tilt_acceleration } = &mut end;
        add([velocity, displacement, acceleration], self.acceleration[0]);
        add([tilt_rate, tilt, tilt_acceleration], self.acceleration[1]);
        end
    }
}

/// A trial under way.
struct Simulation<'a> {
    trial: &'a Trial,
    setup: &'a TrialSetup,
    period: f64,
    contact: AreaContact,
    random: Random,
    /// Motion of the plate now, the accelerations those of the last command that acted.
    plate: PlateKinematics,
    /// Accelerations of the plate: those of the command, or what its servo makes of them.
    servo: Servo,
    /// Commands that do not act yet.
    pending: VecDeque<Command>,
    /// Number of the sampling instant.
    sample: u32,
    /// Pushes that have been given.
    pushed: usize,
    /// Since when nothing moves any more.
    still_since: Option<f64>,
    samples: Vec<TrialSample>,
    controls: Vec<ControlSample>,
}

impl<'a> Simulation<'a> {
    fn new(trial: &'a Trial, setup: &'a TrialSetup, period: f64) -> Result<Self, TrialError> {
        for (name, value) in [("period", period), ("duration", setup.duration)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(PlateError::BadNumber { name, value }.into());
            }
        }
        let law = Friction::Coulomb { mu: trial.plant_mu };
        let mut contact = AreaContact::new(&setup.object, &law, &setup.area)?;
        let [x, y, phi] = trial.start;
        contact.set_state([x, y, phi, 0.0, 0.0, 0.0])?;
        let plate = PlateKinematics::default();
        Ok(Self {
            trial,
            setup,
            period,
            random: Random::new(trial.seed),
            plate,
            servo: Servo::new(setup.servo_bandwidth),
            pending: std::iter::repeat_n(Command::default(), trial.delay).collect(),
            sample: 0,
            pushed: 0,
            still_since: None,
            samples: vec![TrialSample { t: 0.0, object: contact.state(), plate }],
            controls: Vec::new(),
            contact,
        })
    }

    /// One sampling period; how the trial ended if it did.
    fn period<C: PlateController + ?Sized>(&mut self, controller: &mut C) -> Result<Option<TrialOutcome>, TrialError> {
        let t = f64::from(self.sample) * self.period;
        if let Some(next) = self.pending.front() {
            (self.plate.acceleration, self.plate.tilt_acceleration) =
                (next.displacement_acceleration, next.tilt_acceleration);
        }
        let measurement = Measurement { object: self.measure(), plate: self.plate };
        let started = Instant::now();
        let command = controller.command(&measurement);
        let seconds = started.elapsed().as_secs_f64();
        let failed = |reason: String| Ok(Some(TrialOutcome::ControllerFailed { time: t, reason }));
        let command = match command {
            Ok(command) => command,
            Err(error) => return failed(error.to_string()),
        };
        if !(command.displacement_acceleration.is_finite() && command.tilt_acceleration.is_finite()) {
            return failed("a command is not finite".into());
        }
        self.pending.push_back(command);
        let mut acting = self.pending.pop_front().unwrap_or(command);
        if controller.finished() && at_rest(&self.plate) && self.servo.at_rest() {
            self.servo.acceleration = [0.0; 2];
            (self.plate.velocity, self.plate.tilt_rate, acting) = (0.0, 0.0, Command::default());
            self.pending.iter_mut().for_each(|command| *command = acting);
        }
        self.plate.acceleration = acting.displacement_acceleration;
        self.plate.tilt_acceleration = acting.tilt_acceleration;
        self.controls.push(ControlSample { t, measurement, acting, seconds });
        self.sample += 1;
        let end = (f64::from(self.sample) * self.period).min(self.setup.duration);
        let outcome = self.advance(t, end)?;
        let rests = controller.finished() && at_rest(&self.plate) && self.contact.state()[3..] == [0.0; 3];
        self.still_since = if rests { self.still_since.or(Some(end)) } else { None };
        Ok(outcome)
    }

    /// Simulates from the sampling instant `t` to `end`, the accelerations held.
    fn advance(&mut self, t: f64, end: f64) -> Result<Option<TrialOutcome>, TrialError> {
        let (from, servo) = (self.plate, self.servo);
        let after = move |time: f64| servo.after(&from, time);
        let mut motion = move |at: f64| after(at - t);
        let mut rest = self.contact.state()[3..] == [0.0; 3];
        loop {
            let push = self.trial.pushes.get(self.pushed).filter(|push| push.t < end);
            let to = push.map_or(end, |push| push.t.max(self.contact.time()));
            let still = rest
                && servo.at_rest()
                && from == PlateKinematics { displacement: from.displacement, ..PlateKinematics::default() };
            if still && push.is_none() {
                // Nothing moves on a level plate at rest: no steps are needed.
                self.contact.set_time(to)?;
                self.samples.push(TrialSample { t: to, object: self.contact.state(), plate: from });
            } else {
                let samples = &mut self.samples;
                let outcome = self.contact.advance_with(&mut motion, to, |step| {
                    samples.push(TrialSample { t: step.t, object: step.state, plate: after(step.t - t) });
                })?;
                match outcome {
                    AreaOutcome::Finished => {}
                    AreaOutcome::Tipping { t: time, .. } => return Ok(Some(TrialOutcome::Tipping { time })),
                    AreaOutcome::LiftOff { t: time } => return Ok(Some(TrialOutcome::LiftOff { time })),
                    AreaOutcome::NotFinite { t: time } => return Ok(Some(TrialOutcome::NotFinite { time })),
                }
            }
            let Some(push) = push else {
                break;
            };
            let mut state = self.contact.state();
            (0..3).for_each(|i| state[i + 3] += push.velocity[i]);
            self.contact.set_state(state)?;
            self.pushed += 1;
            rest = false;
        }
        self.plate = after(end - t);
        self.servo.acceleration = [self.plate.acceleration, self.plate.tilt_acceleration];
        Ok(None)
    }

    /// The measured pose. A lost one draws its noise as well, so that the others stay the same.
    fn measure(&mut self) -> [f64; 3] {
        let state = self.seen();
        let trial = self.trial;
        let noise = [trial.position_noise, trial.position_noise, trial.angle_noise];
        let measured = std::array::from_fn(|i| state[i] + noise[i] * self.random.normal());
        if self.random.happens(trial.lost) { [f64::NAN; 3] } else { measured }
    }

    /// The state that the camera tells of: the one of a latency ago.
    fn seen(&self) -> [f64; 6] {
        let at = self.contact.time() - self.setup.latency;
        let later = self.samples.partition_point(|sample| sample.t < at);
        match (later.checked_sub(1).and_then(|i| self.samples.get(i)), self.samples.get(later)) {
            _ if self.setup.latency == 0.0 => self.contact.state(),
            (Some(a), Some(b)) => {
                let share = (at - a.t) / (b.t - a.t);
                std::array::from_fn(|i| a.object[i] + share * (b.object[i] - a.object[i]))
            }
            (None, Some(first)) => first.object,
            (_, None) => self.contact.state(),
        }
    }

    fn over(&self) -> bool {
        let t = self.contact.time();
        let dwelt = self.still_since.is_some_and(|since| t - since >= self.setup.dwell);
        t >= self.setup.duration - 1e-9 || (dwelt && self.pushed == self.trial.pushes.len())
    }
}
