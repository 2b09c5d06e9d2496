//! One Dormand–Prince step: its stages, its end, its continuous extension, its error.

use crate::implicit::SLOTS;
use crate::stepper::Stepper;
use crate::tableau::{A, C, D, E};
use crate::trajectory::Trajectory;
use crate::{Mode, Switched};

/// Error allowed in the sticking signs from one order to the other: enough to see every excursion towards ±1.
pub(crate) const SIGN_TOLERANCE: f64 = 1e-4;

/// Steps shorter than this part of the time to go need not resolve the signs: where a load vanishes they jump.
pub(crate) const SIGN_RESOLUTION: f64 = 1e-7;

/// What became of an attempted step.
pub(crate) enum Attempt {
    /// The scaled error of the step.
    Error(f64),
    /// No sticking signs at a stage.
    Unsolvable,
    /// A stage is not finite.
    NonFinite,
}

impl<S: Switched> Stepper<S> {
    /// Evaluates the first stage at the current point; false if nothing holds what should stick.
    pub(crate) fn first_stage(&mut self) -> bool {
        self.multipliers.set_modes(&self.modes);
        for i in 0..self.modes.len() {
            self.multipliers.held[i] = self.departing[i] && self.modes[i] == Mode::Sliding;
        }
        let solved = self.multipliers.field(&mut self.system, self.t, &self.x, &mut self.k[0]);
        self.signs[0].copy_from_slice(&self.multipliers.s);
        self.first_stage_known = solved;
        solved
    }

    /// Hairer's rule for the first step (II.4): one per cent of the time in which the state changes by itself.
    pub(crate) fn first_step(&self, remaining: f64) -> f64 {
        let scale = |x: f64| self.settings.atol + self.settings.rtol * x.abs();
        let (mut d0, mut d1) = (0.0f64, 0.0f64);
        for (x, v) in self.x.iter().zip(&self.k[0]) {
            d0 = d0.max(x.abs() / scale(*x));
            d1 = d1.max(v.abs() / scale(*x));
        }
        let h = if d0 < 1e-5 || d1 < 1e-5 { 1e-6 } else { 0.01 * d0 / d1 };
        // Far from t = 0 even the shortest step is long.
        h.min(1e-2).max(10.0 * self.shortest()).min(remaining)
    }

    /// The stages of a step of length `h`, its end, its continuous extension and its error; the errors of the
    /// sticking signs count if `control_signs`.
    pub(crate) fn attempt(&mut self, h: f64, control_signs: bool) -> Attempt {
        if self.implicit {
            return self.attempt_implicit(h, control_signs);
        }
        let n = self.x.len();
        for i in 1..7 {
            for j in 0..n {
                let sum: f64 = (0..i).map(|l| A[i][l] * self.k[l][j]).sum();
                self.stage[j] = self.x[j] + h * sum;
            }
            let t = self.t + C[i] * h;
            if !self.multipliers.field(&mut self.system, t, &self.stage, &mut self.k[i]) {
                return if self.stage.iter().all(|v| v.is_finite()) { Attempt::Unsolvable } else { Attempt::NonFinite };
            }
            if !self.k[i].iter().all(|v| v.is_finite()) {
                return Attempt::NonFinite;
            }
            self.signs[i].copy_from_slice(&self.multipliers.s);
        }
        self.end.copy_from_slice(&self.stage);
        let mut sum = 0.0;
        for j in 0..n {
            let scale = self.settings.atol + self.settings.rtol * self.x[j].abs().max(self.end[j].abs());
            let e: f64 = (0..7).map(|i| E[i] * self.k[i][j]).sum::<f64>() * h / scale;
            sum += e * e;
            let difference = self.end[j] - self.x[j];
            let bend = h * self.k[0][j] - difference;
            self.coefficients[j] = self.x[j];
            self.coefficients[n + j] = difference;
            self.coefficients[2 * n + j] = bend;
            self.coefficients[3 * n + j] = difference - h * self.k[6][j] - bend;
            self.coefficients[4 * n + j] = h * (0..7).map(|i| D[i] * self.k[i][j]).sum::<f64>();
        }
        let mut error = (sum / n.max(1) as f64).sqrt();
        for (i, mode) in self.modes.iter().enumerate() {
            if control_signs && *mode == Mode::Sticking {
                for c in self.multipliers.parts[i].clone() {
                    let e: f64 = (0..7).map(|l| E[l] * self.signs[l][c]).sum();
                    error = error.max(e.abs() / SIGN_TOLERANCE);
                }
            }
        }
        if error.is_nan() { Attempt::NonFinite } else { Attempt::Error(error) }
    }

    /// Takes over the attempted step.
    pub(crate) fn accept(&mut self, h: f64, trajectory: &mut Option<&mut Trajectory>) {
        if let Some(trajectory) = trajectory {
            trajectory.push(self.t, h, &self.coefficients, &self.end);
            if self.implicit {
                trajectory.keep_directions(SLOTS.iter().map(|&slot| &self.signs[slot]));
            }
        }
        self.record_step(h);
        std::mem::swap(&mut self.x, &mut self.end);
        self.t += h;
        self.multipliers.project(&mut self.system, self.t, &mut self.x, &mut self.sigma);
        self.k.swap(0, 6);
        self.signs.swap(0, 6);
        self.multipliers.s.copy_from_slice(&self.signs[0]);
        self.departing.fill(false);
        self.multipliers.held.fill(false);
        self.statistics.steps += 1;
        self.stalled = 0;
        self.failed.clear();
    }

    /// The stages of a step of length `h` without error control, as for the step to an event.
    pub(crate) fn attempt_to_event(&mut self, h: f64) -> bool {
        matches!(self.attempt(h, false), Attempt::Error(_))
    }
}
