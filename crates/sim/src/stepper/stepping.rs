//! The steps between events, breaks and mode changes, of any system: compiled once.

use super::Stepper;
use crate::Switched;
use crate::events::{Scan, gap_at_end};
use crate::friction::{FrictionMode, SIMULTANEOUS, resolve};
use crate::integrate::{Approach, Attempt, Control, Method, Step, attempt};
use crate::outcome::{Outcome, StopReason};
use crate::sensitivity::FieldBefore;

/// Steps shorter than this part of the time to go need not resolve the signs: where a load vanishes they jump.
const SIGN_RESOLUTION: f64 = 1e-7;

impl Stepper<dyn Switched + '_> {
    /// Modes by the signs of the switching functions alone; `restart` decides on those that vanish.
    pub(super) fn guess_modes(&mut self) {
        self.segment_end = self.field.system.enter_segment(self.step.t);
        self.field.guess_modes(self.step.t, &self.step.x);
        self.stiffness.forget();
        self.step.started = false;
        self.h = 0.0;
    }

    /// Integrates to `t_end`, and is ready to go on whatever happens.
    pub(super) fn run(&mut self, t_end: f64) -> Outcome {
        match self.run_segments(t_end) {
            Ok(()) => Outcome::Finished,
            Err(reason) => {
                // Other inputs may lead on from here, with a step length of their own.
                self.h = 0.0;
                self.guard.go_on();
                self.field.reset();
                Outcome::Stopped { reason, t: self.step.t, state: self.step.x.clone() }
            }
        }
    }

    fn attempts(&self) -> usize {
        self.statistics.steps + self.statistics.rejected
    }

    fn run_segments(&mut self, t_end: f64) -> Result<(), StopReason> {
        if !t_end.is_finite() {
            return Err(StopReason::NonFinite);
        }
        self.restart()?;
        let first = self.attempts();
        while self.step.t < t_end {
            if self.settings.stop.is_raised() {
                return Err(StopReason::Asked);
            }
            if self.step.t >= self.segment_end {
                self.restart()?;
            }
            if self.attempts() - first >= self.settings.max_steps {
                return Err(StopReason::TooManySteps { limit: self.settings.max_steps });
            }
            self.go_on(t_end.min(self.segment_end))?;
        }
        Ok(())
    }

    /// Enters the segment that starts now, and makes the modes consistent with it.
    fn restart(&mut self) -> Result<(), StopReason> {
        let (t, x) = (self.step.t, &self.step.x);
        self.segment_end = self.field.system.enter_segment(t);
        if self.segment_end.is_nan() || self.segment_end <= t {
            return Err(StopReason::EmptySegment);
        }
        if !x.iter().all(|v| v.is_finite()) {
            return Err(StopReason::NonFinite);
        }
        self.step.started = false;
        self.guard.failed.clear();
        if self.field.modes.is_empty() {
            return Ok(());
        }
        let before = self.field.modes.clone();
        if !self.zero.at_start(&mut self.field, (t, x), self.settings.atol) {
            return Err(StopReason::NonFinite);
        }
        self.resolve_modes(&before)
    }

    /// Gives the zero set consistent modes, projects what sticks, logs what changed since the modes `before`.
    fn resolve_modes(&mut self, before: &[FrictionMode]) -> Result<(), StopReason> {
        let Self { field, step, zero, guard, settings, .. } = self;
        let (t, x) = (step.t, &mut step.x);
        resolve(field, (t, &*x), zero, &guard.failed, settings.max_zero_set)
            .map_err(|reason| if field.is_finite(t, x) { reason } else { StopReason::NonFinite })?;
        // A segment that goes on in the same modes is as stiff as the one before, nearly.
        if field.modes != before {
            self.stiffness.forget();
            step.newton.forget();
        }
        field.departing.fill(false);
        for entry in &zero.entries {
            field.departing[entry.switch] = field.modes[entry.switch] != FrictionMode::Sticking;
        }
        field.project(t, x);
        if let Some(trajectory) = &mut self.trajectory {
            trajectory.push_mode_changes(t, before, &field.modes);
        }
        step.started = false;
        Ok(())
    }

    /// One accepted step, or one event, not beyond `limit`.
    fn go_on(&mut self, limit: f64) -> Result<(), StopReason> {
        let remaining = limit - self.step.t;
        if remaining <= self.step.shortest() {
            self.step.t = limit;
            return Ok(());
        }
        if !self.step.started && !self.step.start(&mut self.field) {
            return self.change_unsolvable();
        }
        if !self.step.k[0].iter().all(|v| v.is_finite()) {
            return Err(StopReason::NonFinite);
        }
        if self.h == 0.0 {
            self.h = self.step.first_length(&self.settings, remaining);
        }
        let times = (remaining, self.settings.atol);
        let longest = match self.stiffness.approach(&mut self.field, &self.step, times, &mut self.h) {
            Approach::None => self.settings.max_step,
            Approach::Within(longest) => self.settings.max_step.min(longest),
            Approach::Arrives { switch, after } => return self.arrive(switch, after),
        };
        let mut most = 8.0;
        loop {
            let h = self.length(remaining, longest)?;
            let error = match self.attempt(h, h > SIGN_RESOLUTION * remaining) {
                Attempt::Error(error) if error <= 1.0 => error,
                failed => {
                    self.statistics.rejected += 1;
                    most = 1.0;
                    match failed {
                        Attempt::Error(_) => self.regime.note_rejected(&self.step, h, &self.settings),
                        _ => self.regime.note_failure(&self.step, h),
                    }
                    self.h = match failed {
                        Attempt::Error(error) => h * (0.9 * error.powf(self.exponent())).clamp(0.1, 0.9),
                        _ => 0.25 * h,
                    };
                    if self.h >= self.step.shortest() {
                        continue;
                    }
                    return match failed {
                        Attempt::Unsolvable => self.change_unsolvable(),
                        Attempt::NonFinite => Err(StopReason::NonFinite),
                        Attempt::Error(_) => Err(StopReason::StepTooSmall),
                    };
                }
            };
            match self.scan(h) {
                Scan::Clear => {}
                Scan::Unresolved => {
                    self.statistics.rejected += 1;
                    most = 1.0;
                    self.h = 0.5 * h;
                    continue;
                }
                Scan::Event { theta, switch } => return self.meet(theta, h, switch),
            }
            self.accept(h);
            let at_limit = h == remaining;
            if at_limit {
                self.step.t = limit;
            }
            // A step cut short by its limit says nothing against the length before.
            if !(at_limit && self.h >= most * h) {
                let mut growth = (0.9 * error.max(1e-10).powf(self.exponent())).clamp(0.2, most);
                if self.step.method == Method::Stiff && self.step.newton.keeps_length() && (1.0..1.2).contains(&growth)
                {
                    growth = 1.0;
                }
                self.h = if at_limit { self.h.max(h * growth) } else { h * growth };
            }
            return Ok(());
        }
    }

    /// The length to try, such that no sliver of the remaining time is left, and its method.
    fn length(&mut self, remaining: f64, longest: f64) -> Result<f64, StopReason> {
        let mut h = self.h.min(longest);
        if h >= remaining * 0.999 {
            h = remaining;
        } else if h > 0.5 * remaining {
            h = 0.5 * remaining;
        }
        if h < self.step.shortest() && h < remaining {
            return Err(StopReason::StepTooSmall);
        }
        let attempts = self.attempts();
        self.step.method = if self.stiffness.is_stiff(&mut self.field, &self.step, h, attempts) {
            Method::Directions
        } else if self.regime.is_stiff() {
            Method::Stiff
        } else {
            Method::Explicit
        };
        Ok(h)
    }

    /// By which power of its error a step's length changes: the error estimates are of order 5 and 4.
    fn exponent(&self) -> f64 {
        if self.step.method == Method::Explicit { -0.2 } else { -0.25 }
    }

    fn attempt(&mut self, h: f64, control_signs: bool) -> Attempt {
        attempt(&mut self.step, &mut self.field, h, Control { settings: &self.settings, signs: control_signs })
    }

    /// As [`Stepper::attempt`] without error control, as for the step to an event; whether it has a solution.
    fn reaches(&mut self, h: f64) -> bool {
        matches!(self.attempt(h, false), Attempt::Error(_))
    }

    fn scan(&mut self, h: f64) -> Scan {
        if self.field.modes.is_empty() {
            return Scan::Clear;
        }
        self.locator.scan(&mut self.field, &self.step, h, self.settings.atol)
    }

    /// Takes over the attempted step.
    fn accept(&mut self, h: f64) {
        if let Some(trajectory) = &mut self.trajectory {
            trajectory.push(&self.step, h);
        }
        if let Some(path) = &mut self.path {
            path.push_step(&self.step, h, &self.field.modes);
        }
        self.regime.note(&mut self.step, h, &self.settings);
        self.step.accept(&mut self.field, h);
        self.statistics.steps += 1;
        self.guard.go_on();
    }

    /// Steps to the event of `switch` at fraction `theta` of the step `h`, and changes the modes there.
    fn meet(&mut self, theta: f64, h: f64, switch: usize) -> Result<(), StopReason> {
        let breaks = self.field.modes[switch] == FrictionMode::Sticking;
        let shortest = self.step.shortest();
        if theta * h <= shortest {
            self.guard.failed.push(self.field.modes.clone());
            return self.change_modes(switch, breaks);
        }
        let secant = self.locator.secant(&mut self.field, &self.step, (theta, h), switch);
        let resolution = 0.01 * SIMULTANEOUS * self.step.t.abs().max(1.0);
        let mut length = theta * h;
        let mut solved = self.reaches(length);
        for _ in 0..3 {
            if !solved {
                break;
            }
            let (gap, slope) = gap_at_end(&mut self.field, &self.step, length, switch, secant);
            let correction = -gap / slope;
            let next = length + correction;
            if !(slope < 0.0 && correction.abs() < 1e-2 * h && next > shortest) || correction.abs() <= resolution {
                break;
            }
            length = next;
            solved = self.reaches(length);
        }
        if solved {
            self.accept(length);
            return self.change_modes(switch, breaks);
        }
        // The field ends before the event: approach it by shorter steps.
        self.h = 0.5 * length;
        if self.h > shortest { Ok(()) } else { self.change_unsolvable() }
    }

    /// The last step of a unit vector to zero, in its present direction, and what follows.
    fn arrive(&mut self, switch: usize, after: f64) -> Result<(), StopReason> {
        if after > self.step.shortest() {
            let Self { field, step, settings, .. } = self;
            field.hold_directions(field.arriving_with(switch, &step.x, settings.atol));
            step.method = Method::Explicit;
            let solved = self.reaches(after);
            self.field.release_directions();
            if !solved {
                return Err(StopReason::NonFinite);
            }
            self.accept(after);
        }
        self.change_modes(switch, false)
    }

    /// Changes the modes at the event of `switch`, which `breaks` loose or reaches zero.
    fn change_modes(&mut self, switch: usize, breaks: bool) -> Result<(), StopReason> {
        let Step { t, x, k, signs, .. } = &self.step;
        self.zero.at_event(&mut self.field, (*t, x), (&k[0], &signs[0]), (switch, breaks), self.settings.atol);
        self.count_event()?;
        let modes = self.field.modes.clone();
        // What breaks loose does so without a jump of the field.
        let follows = self.path.is_some() && !breaks;
        let before = follows.then(|| FieldBefore::new(&self.field, &self.step, switch));
        self.resolve_modes(&modes)?;
        if let (Some(path), Some(before)) = (&mut self.path, before)
            && self.step.start(&mut self.field)
        {
            path.push_jump(&before, &self.step.k[0]);
        }
        Ok(())
    }

    /// The sticking signs have no solution at the current point: the modes cannot be kept, others are sought.
    fn change_unsolvable(&mut self) -> Result<(), StopReason> {
        self.zero.of_unsolvable(&mut self.field, (self.step.t, &self.step.x));
        let before = self.field.modes.clone();
        self.guard.failed.push(before.clone());
        self.count_event()?;
        self.h = self.h.max(1e3 * self.step.shortest());
        self.resolve_modes(&before)
    }

    /// Counts an event at the current time against chattering.
    fn count_event(&mut self) -> Result<(), StopReason> {
        self.statistics.events += 1;
        self.guard.count(self.step.t, self.field.modes.len(), &self.zero, &self.settings)
    }
}
