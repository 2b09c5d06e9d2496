//! The integrator: adaptive Dormand–Prince steps between events, breaks and mode changes.

use crate::arrival::Approach;
use crate::multipliers::{Multipliers, norm};
use crate::path::Path;
use crate::resolve::{ZeroSet, resolve};
use crate::stages::{Attempt, SIGN_RESOLUTION};
use crate::trajectory::Trajectory;
use crate::{Mode, ModeChange, Outcome, Settings, SimError, Statistics, StopReason, Switched};
use std::collections::VecDeque;

/// A re-entrant integrator: keeps time, state, modes and step length from one call to the next.
///
/// ```
/// use bracketry_sim::{Closures, Mode, Settings, Stepper};
/// let block = Closures {
///     dim: 1,
///     switches: 1,
///     rhs: |t: f64, _x: &[f64], s: &[f64], dx: &mut [f64]| dx[0] = 2.0 * t.sin() - s[0],
///     switching: |_t, x: &[f64], sigma: &mut [f64]| sigma[0] = x[0],
///     gradient: |_t, _x: &[f64], g: &mut [f64], _dt: &mut [f64]| g[0] = 1.0,
/// };
/// let mut stepper = Stepper::new(block, 0.0, &[0.0], &Settings::default()).unwrap();
/// assert!(stepper.advance(0.5).is_finished()); // 2 sin 0.5 < 1: it holds
/// assert_eq!((stepper.state(), stepper.modes()), (&[0.0][..], &[Mode::Sticking][..]));
/// assert!(stepper.advance(0.6).is_finished()); // breaks loose at asin(1/2) = 0.5236
/// assert_eq!(stepper.modes(), &[Mode::Positive]);
/// ```
#[derive(Debug, Clone)]
pub struct Stepper<S> {
    pub(crate) system: S,
    pub(crate) settings: Settings,
    pub(crate) t: f64,
    pub(crate) x: Vec<f64>,
    pub(crate) modes: Vec<Mode>,
    /// Switches that have just left zero: their sign is known although `σ` is still rounding.
    pub(crate) departing: Vec<bool>,
    pub(crate) h: f64,
    segment_end: f64,
    /// Whether the step under way is implicit.
    pub(crate) implicit: bool,
    /// The influence of sliding directions on their own σ̇, and the step at which it was measured.
    pub(crate) influence_size: f64,
    pub(crate) influence_at: Option<usize>,
    /// Least |σ| of the sliding unit vectors at the current point.
    pub(crate) nearest: f64,
    pub(crate) first_stage_known: bool,
    pub(crate) multipliers: Multipliers,
    pub(crate) k: [Vec<f64>; 7],
    pub(crate) signs: [Vec<f64>; 7],
    pub(crate) stage: Vec<f64>,
    pub(crate) end: Vec<f64>,
    pub(crate) end_velocity: Vec<f64>,
    pub(crate) coefficients: Vec<f64>,
    pub(crate) sigma: Vec<f64>,
    pub(crate) zero: ZeroSet,
    pub(crate) gaps: Vec<f64>,
    pub(crate) samples: Vec<f64>,
    pub(crate) rates: [Vec<f64>; 2],
    pub(crate) noise: Vec<f64>,
    /// Modes that could not be kept for any time at the current instant.
    pub(crate) failed: Vec<Vec<Mode>>,
    pub(crate) recent: VecDeque<f64>,
    pub(crate) stalled: usize,
    pub(crate) statistics: Statistics,
    pub(crate) path: Option<Path>,
}

impl<S: Switched> Stepper<S> {
    /// Starts at time `t` in state `x` (length `n`); the modes follow from the switching functions there.
    ///
    /// # Errors
    /// [`SimError`] for a state of the wrong length, a time that is not finite, or settings without meaning.
    pub fn new(system: S, t: f64, x: &[f64], settings: &Settings) -> Result<Self, SimError> {
        settings.check()?;
        let (n, switches) = (system.dim(), system.switches());
        let multipliers = Multipliers::new(&system);
        let k = multipliers.s.len();
        if x.len() != n {
            return Err(SimError::WrongLength { what: "the state", expected: n, found: x.len() });
        }
        if !t.is_finite() {
            return Err(SimError::BadTimeSpan { from: t, to: t });
        }
        let mut stepper = Self {
            system,
            settings: settings.clone(),
            t,
            x: x.to_vec(),
            modes: vec![Mode::Sticking; switches],
            departing: vec![false; switches],
            h: 0.0,
            segment_end: f64::NEG_INFINITY,
            implicit: false,
            influence_size: 0.0,
            influence_at: None,
            nearest: f64::INFINITY,
            first_stage_known: false,
            multipliers,
            k: std::array::from_fn(|_| vec![0.0; n]),
            signs: std::array::from_fn(|_| vec![0.0; k]),
            stage: vec![0.0; n],
            end: vec![0.0; n],
            end_velocity: vec![0.0; n],
            coefficients: vec![0.0; 5 * n],
            sigma: vec![0.0; k],
            zero: ZeroSet::default(),
            gaps: vec![0.0; switches],
            samples: vec![0.0; 5 * switches],
            rates: std::array::from_fn(|_| vec![0.0; switches]),
            noise: vec![0.0; switches],
            failed: Vec::new(),
            recent: VecDeque::new(),
            stalled: 0,
            statistics: Statistics::default(),
            path: None,
        };
        stepper.guess_modes();
        Ok(stepper)
    }

    /// Current time in seconds.
    pub fn time(&self) -> f64 {
        self.t
    }

    /// Current state.
    pub fn state(&self) -> &[f64] {
        &self.x
    }

    /// Current modes, one per switch.
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// The system.
    pub fn system(&self) -> &S {
        &self.system
    }

    /// The system, to change its inputs or parameters; the modes are made consistent at the next call of `advance`.
    pub fn system_mut(&mut self) -> &mut S {
        &mut self.system
    }

    /// Work done so far.
    pub fn statistics(&self) -> Statistics {
        Statistics { rhs: self.multipliers.evaluations, ..self.statistics }
    }

    /// Puts the system into another state at another time; the modes follow from the switching functions there.
    ///
    /// # Errors
    /// [`SimError`] for a state of the wrong length or a time that is not finite.
    pub fn set_state(&mut self, t: f64, x: &[f64]) -> Result<(), SimError> {
        if x.len() != self.x.len() {
            return Err(SimError::WrongLength { what: "the state", expected: self.x.len(), found: x.len() });
        }
        if !t.is_finite() {
            return Err(SimError::BadTimeSpan { from: t, to: t });
        }
        self.t = t;
        self.x.copy_from_slice(x);
        self.recent.clear();
        self.guess_modes();
        Ok(())
    }

    /// Modes by the signs of the switching functions alone; `restart` decides those that vanish.
    fn guess_modes(&mut self) {
        self.segment_end = self.system.enter_segment(self.t);
        self.system.switching(self.t, &self.x, &mut self.sigma);
        for i in 0..self.modes.len() {
            self.departing[i] = false;
            self.modes[i] = self.mode_of(i, norm(&self.sigma[self.multipliers.parts[i].clone()]) == 0.0);
        }
        self.first_stage_known = false;
        self.h = 0.0;
    }

    /// The mode of a switch by its σ (the last evaluated), which vanishes or not.
    fn mode_of(&self, switch: usize, vanishes: bool) -> Mode {
        match self.multipliers.parts[switch].start {
            _ if vanishes => Mode::Sticking,
            _ if self.multipliers.is_vector(switch) => Mode::Sliding,
            first => Mode::of_sign(self.sigma[first]),
        }
    }

    /// Integrates to `t_end`; does nothing if that lies in the past, and stops at once if it is not finite.
    pub fn advance(&mut self, t_end: f64) -> Outcome {
        self.run(t_end, None)
    }

    /// Integrates to `t_end` and records the way.
    ///
    /// # Errors
    /// [`SimError::BadTimeSpan`] if `t_end` is not finite, or lies before the current time.
    pub fn record(&mut self, t_end: f64) -> Result<(Trajectory, Outcome), SimError> {
        if !t_end.is_finite() || t_end < self.t {
            return Err(SimError::BadTimeSpan { from: self.t, to: t_end });
        }
        let mut trajectory = Trajectory::new(self.t, &self.x, &self.modes);
        let outcome = self.run(t_end, Some(&mut trajectory));
        trajectory.finish(self.t, &self.x);
        Ok((trajectory, outcome))
    }

    fn run(&mut self, t_end: f64, mut trajectory: Option<&mut Trajectory>) -> Outcome {
        match self.run_segments(t_end, &mut trajectory) {
            Ok(()) => Outcome::Finished,
            Err(reason) => {
                // Other inputs may lead on from here, with a step length of their own.
                self.h = 0.0;
                self.stalled = 0;
                self.failed.clear();
                self.multipliers.reset();
                Outcome::Stopped { reason, t: self.t, state: self.x.clone() }
            }
        }
    }

    fn run_segments(&mut self, t_end: f64, trajectory: &mut Option<&mut Trajectory>) -> Result<(), StopReason> {
        if !t_end.is_finite() {
            return Err(StopReason::NonFinite);
        }
        self.restart(trajectory)?;
        let first = self.statistics.steps + self.statistics.rejected;
        while self.t < t_end {
            if self.settings.stop.is_raised() {
                return Err(StopReason::Asked);
            }
            if self.t >= self.segment_end {
                self.restart(trajectory)?;
            }
            if self.statistics.steps + self.statistics.rejected - first >= self.settings.max_steps {
                return Err(StopReason::TooManySteps { limit: self.settings.max_steps });
            }
            self.step(t_end.min(self.segment_end), trajectory)?;
        }
        Ok(())
    }

    /// Enters the segment that begins now, and makes the modes consistent with it.
    fn restart(&mut self, trajectory: &mut Option<&mut Trajectory>) -> Result<(), StopReason> {
        self.segment_end = self.system.enter_segment(self.t);
        if self.segment_end.is_nan() || self.segment_end <= self.t {
            return Err(StopReason::EmptySegment);
        }
        if !self.x.iter().all(|v| v.is_finite()) {
            return Err(StopReason::NonFinite);
        }
        self.first_stage_known = false;
        self.failed.clear();
        let switches = self.modes.len();
        if switches == 0 {
            return Ok(());
        }
        self.system.switching(self.t, &self.x, &mut self.sigma);
        if !self.sigma.iter().all(|v| v.is_finite()) {
            return Err(StopReason::NonFinite);
        }
        let before = self.modes.clone();
        self.multipliers.gradients(&mut self.system, self.t, &self.x);
        self.zero.clear();
        for i in 0..switches {
            let part = self.multipliers.parts[i].clone();
            let size = self.rounding(i);
            let tiny = if part.len() > 1 { self.arrival_size(i) } else { self.negligible(i) };
            let sigma = norm(&self.sigma[part]);
            match self.modes[i] {
                Mode::Sticking if sigma <= 1e5 * size + tiny => {
                    self.zero.push(i, self.multipliers.sliding_mode(i), false);
                }
                sliding if sliding != Mode::Sticking && (self.departing[i] || sigma <= tiny) => {
                    self.zero.push(i, sliding, false);
                }
                _ => self.modes[i] = self.mode_of(i, false),
            }
        }
        self.settle(&before, trajectory)
    }

    /// Gives the zero set consistent modes, projects what sticks, logs what changed.
    pub(crate) fn settle(
        &mut self,
        before: &[Mode],
        trajectory: &mut Option<&mut Trajectory>,
    ) -> Result<(), StopReason> {
        resolve(
            &mut self.system,
            &mut self.multipliers,
            (self.t, &self.x),
            (&self.zero, &self.failed),
            self.settings.max_zero_set,
            &mut self.modes,
            &mut self.stage,
        )
        .map_err(|reason| if self.rate_is_finite() { reason } else { StopReason::NonFinite })?;
        self.departing.fill(false);
        self.influence_at = None;
        for &i in &self.zero.switches {
            self.departing[i] = self.modes[i] != Mode::Sticking;
        }
        self.multipliers.project(&mut self.system, self.t, &mut self.x, &mut self.sigma);
        if let Some(trajectory) = trajectory {
            for (switch, (&from, &to)) in before.iter().zip(&self.modes).enumerate() {
                if from != to {
                    trajectory.push_mode_change(ModeChange { t: self.t, switch, from, to });
                }
            }
        }
        self.first_stage_known = false;
        Ok(())
    }

    /// Whether the right-hand side at the current point, with some signs, is finite; where it is not, no mode fits.
    fn rate_is_finite(&mut self) -> bool {
        let mut signs = vec![0.0; self.multipliers.s.len()];
        for (part, mode) in self.multipliers.parts.iter().zip(&self.modes) {
            signs[part.start] = mode.sign();
        }
        self.system.rhs(self.t, &self.x, &signs, &mut self.stage);
        self.stage.iter().all(|v| v.is_finite())
    }

    /// The shortest step that the resolution of time allows.
    pub(crate) fn shortest(&self) -> f64 {
        4.0 * f64::EPSILON * self.t.abs().max(1e-3)
    }

    /// One accepted step, or one event, not beyond `limit`.
    fn step(&mut self, limit: f64, trajectory: &mut Option<&mut Trajectory>) -> Result<(), StopReason> {
        let remaining = limit - self.t;
        if remaining <= self.shortest() {
            self.t = limit;
            return Ok(());
        }
        if !self.first_stage_known && !self.first_stage() {
            return self.unsolvable(trajectory);
        }
        if !self.k[0].iter().all(|v| v.is_finite()) {
            return Err(StopReason::NonFinite);
        }
        if self.h == 0.0 {
            self.h = self.first_step(remaining);
        }
        let longest = match self.approach(remaining) {
            Approach::None => self.settings.max_step,
            Approach::Within(longest) => self.settings.max_step.min(longest),
            Approach::Arrives { switch, after } => return self.arrive(switch, after, trajectory),
        };
        let mut rejected = false;
        loop {
            let mut h = self.h.min(longest);
            if h >= remaining * 0.999 {
                h = remaining;
            } else if h > 0.5 * remaining {
                h = 0.5 * remaining;
            }
            if h < self.shortest() && h < remaining {
                return Err(StopReason::StepTooSmall);
            }
            self.implicit = self.is_stiff(h);
            let attempt = self.attempt(h, h > SIGN_RESOLUTION * remaining);
            let error = match attempt {
                Attempt::Error(error) if error <= 1.0 => error,
                other => {
                    self.statistics.rejected += 1;
                    rejected = true;
                    self.h = match other {
                        Attempt::Error(error) => h * (0.9 * error.powf(self.exponent())).clamp(0.1, 0.9),
                        _ => 0.25 * h,
                    };
                    if self.h < self.shortest() {
                        return match other {
                            Attempt::Unsolvable => self.unsolvable(trajectory),
                            Attempt::NonFinite => Err(StopReason::NonFinite),
                            Attempt::Error(_) => Err(StopReason::StepTooSmall),
                        };
                    }
                    continue;
                }
            };
            if !self.modes.is_empty() {
                match self.scan(h) {
                    crate::events::Scan::Clear => {}
                    crate::events::Scan::Unresolved => {
                        self.statistics.rejected += 1;
                        rejected = true;
                        self.h = 0.5 * h;
                        continue;
                    }
                    crate::events::Scan::Event { theta, switch } => {
                        return self.event(theta, h, switch, trajectory);
                    }
                }
            }
            let at_limit = h == remaining;
            self.accept(h, trajectory);
            if at_limit {
                self.t = limit;
            }
            let most = if rejected { 1.0 } else { 8.0 };
            // A step cut short by its limit says nothing against the length before.
            if !(at_limit && self.h >= most * h) {
                let growth = (0.9 * error.max(1e-10).powf(self.exponent())).clamp(0.2, most);
                self.h = if at_limit { self.h.max(h * growth) } else { h * growth };
            }
            return Ok(());
        }
    }

    /// By which power of its error a step's length changes: the error estimates are of order 5 and 4.
    fn exponent(&self) -> f64 {
        if self.implicit { -0.25 } else { -0.2 }
    }

    /// The sticking signs have no solution at the current point: the modes cannot be kept, others are sought.
    pub(crate) fn unsolvable(&mut self, trajectory: &mut Option<&mut Trajectory>) -> Result<(), StopReason> {
        self.zero.clear();
        for (i, mode) in self.modes.iter().enumerate() {
            if *mode == Mode::Sticking || *mode == Mode::Sliding && self.departing[i] {
                self.zero.push(i, self.multipliers.sliding_mode(i), false);
            }
        }
        let before = self.modes.clone();
        self.failed.push(self.modes.clone());
        self.count_event()?;
        self.h = self.h.max(1e3 * self.shortest());
        self.settle(&before, trajectory)
    }

    /// Counts an event at the current time against chattering.
    pub(crate) fn count_event(&mut self) -> Result<(), StopReason> {
        self.statistics.events += 1;
        self.stalled += 1;
        if self.stalled > 8 + 9 * self.modes.len() {
            return Err(StopReason::NoConsistentMode { switches: self.zero.switches.clone() });
        }
        let (limit, window) = (self.settings.max_events, self.settings.event_window);
        self.recent.push_back(self.t);
        if self.recent.len() > limit
            && let Some(first) = self.recent.pop_front()
            && self.t - first <= window
        {
            return Err(StopReason::TooManyEvents { limit, window });
        }
        Ok(())
    }
}
