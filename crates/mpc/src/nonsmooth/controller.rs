//! Receding-horizon control on the exact stick–slip flow.
//!
//! Every iterate is a roll-out of the exact flow from the measured state, so no plan rests on creep that does not exist. A
//! quadratic program along the roll-out, with the derivative of the exact flow across events, proposes the step; it is taken
//! when the exact cost falls. Inputs of intervals that stick are kept within the friction that holds, because the derivative
//! there is zero and promises nothing beyond. From sticking no derivative leads out: what sticks at the start is let slip
//! by force in either direction in a second program, and the push is taken when the exact cost of its roll-out is lower.

use super::flow::{FrictionMode, ModeChange, StickSlipFlow};
use super::switched_field::SwitchedField;
use crate::controller::Controller;
use crate::dynamics::SymbolicDynamics;
use crate::error::{MpcError, check_length};
use crate::faults::StepLimits;
use crate::integrator::Integrator;
use crate::ocp::{Ocp, Substeps};
use crate::policy::{FailurePolicy, Failures, rest_input};
use crate::qp::{Qp, QpSettings, QpStatus};
use crate::shooting::{Linearisation, Shooter};
use crate::sqp::{Sqp, SqpSettings};
use crate::step::{FallbackReason, InputSource, Step, StepStatus, Timings};
use crate::trajectory::Trajectory;
use bracketry_system::System;
use std::time::Instant;

/// Settings of [`StickSlipController`].
#[derive(Clone, Debug, PartialEq)]
pub struct StickSlipSettings {
    /// Largest number of quadratic programs per sample along the plan; 1 is the real-time iteration.
    pub iterations: usize,
    /// Largest number of quadratic programs for the first plan.
    pub initial_iterations: usize,
    /// The iteration stops when a step lowers the cost by less than this fraction of it.
    pub tolerance: f64,
    /// Smoothing widths of the solution that the first plan starts from, from wide to narrow; none starts from the guess.
    pub smoothing: Vec<f64>,
    /// Width by which unit vectors σ/|σ| are rounded, in the unit of σ.
    pub rounding: f64,
    /// What is applied when a sample has no solution.
    pub failure: FailurePolicy,
    /// Input of rest; zero, or the bound closest to it, when empty.
    pub rest_input: Vec<f64>,
    /// Settings of the quadratic programs.
    pub qp: QpSettings,
}

impl Default for StickSlipSettings {
    fn default() -> Self {
        Self {
            iterations: 1,
            initial_iterations: 50,
            tolerance: 1e-6,
            smoothing: vec![0.1, 0.01],
            rounding: 1e-3,
            failure: FailurePolicy::default(),
            rest_input: Vec::new(),
            qp: QpSettings::default(),
        }
    }
}

/// What the flow said of one interval of the plan.
#[derive(Clone, Default)]
struct Interval {
    modes: Vec<FrictionMode>,
    signs: Vec<f64>,
    rows: Vec<f64>,
    changes: Vec<ModeChange>,
}

impl Interval {
    /// Whether the switch sticks from start to end.
    fn sticks(&self, switch: usize) -> bool {
        self.modes[switch] == FrictionMode::Sticking && self.changes.iter().all(|c| c.switch != switch)
    }
}

/// The controller.
pub struct StickSlipController {
    ocp: Ocp,
    flow: StickSlipFlow,
    qp: Qp,
    lin: Linearisation,
    settings: StickSlipSettings,
    plan: Trajectory,
    intervals: Vec<Interval>,
    k0: usize,
    failures: Failures,
    limits: StepLimits,
    lambda: f64,
    started: bool,
    smooth: Option<Sqp>,
}

/// Smallest proximal weight that is used; below it the term is left out.
const MIN_PROXIMAL: f64 = 1e-6;

impl StickSlipController {
    /// A controller for the system, with `guess` as the first inputs.
    ///
    /// # Errors
    /// If the problem contradicts itself, the system or the guess.
    pub fn new(system: &System, ocp: Ocp, guess: Trajectory, settings: StickSlipSettings) -> Result<Self, MpcError> {
        let dynamics = SymbolicDynamics::new(system)?;
        let shooter = Shooter::new(&dynamics, Integrator::Rk4);
        let flow = StickSlipFlow::new(SwitchedField::new(system, settings.rounding)?);
        ocp.check(flow.field.states, flow.field.inputs)?;
        check_length("the states of the guess", guess.states(), ocp.states())?;
        check_length("the inputs of the guess", guess.inputs(), ocp.inputs())?;
        check_length("the guess", guess.steps(), ocp.steps)?;
        settings.failure.check(ocp.states(), ocp.inputs())?;
        let rest = rest_input(&settings.rest_input, &ocp.input_bounds)?;
        let failures = Failures::new(settings.failure.clone(), rest, ocp.states(), guess.steps());
        let smooth = if settings.smoothing.is_empty() || flow.field.switches == 0 {
            None
        } else {
            let sqp = SqpSettings { smoothing: settings.smoothing.clone(), qp: settings.qp, ..SqpSettings::default() };
            Some(Sqp::new(Box::new(dynamics), ocp.clone(), sqp)?)
        };
        Ok(Self {
            qp: Qp::new(&ocp, ocp.steps, shooter.closure(), settings.qp),
            lin: Linearisation::default(),
            intervals: vec![Interval::default(); ocp.steps],
            failures,
            limits: StepLimits::default(),
            plan: guess,
            k0: 0,
            lambda: 0.0,
            started: false,
            smooth,
            ocp,
            flow,
            settings,
        })
    }

    /// The trajectory that the next input comes from.
    pub fn plan(&self) -> &Trajectory {
        &self.plan
    }

    /// The changes of mode along the plan as it was last linearised, in order of time.
    pub fn mode_changes(&self) -> impl Iterator<Item = &ModeChange> {
        self.intervals.iter().flat_map(|i| &i.changes)
    }

    fn substeps(&self) -> usize {
        let (Substeps::Fixed(s) | Substeps::AtLeast(s)) = self.ocp.substeps;
        s
    }

    fn time(&self, k: usize) -> f64 {
        (self.k0 + k) as f64 * self.ocp.dt
    }

    /// Cost and penalties of a roll-out.
    fn cost(&mut self, z: &Trajectory) -> f64 {
        self.ocp.cost(self.k0, z) + self.ocp.penalty(self.k0, z, self.settings.qp.hard_weight)
    }

    /// States that follow from the first one and the inputs; infinite cost where the flow fails.
    fn roll_out(&mut self, z: &mut Trajectory) -> f64 {
        let (dt, substeps) = (self.ocp.dt, self.substeps());
        for k in 0..z.steps() {
            let mut x = z.x(k).to_vec();
            let t = self.time(k);
            if !self.flow.advance(t, &mut x, z.u(k), dt, substeps, None, None) {
                return f64::INFINITY;
            }
            z.x_mut(k + 1).copy_from_slice(&x);
        }
        let cost = self.cost(z);
        if cost.is_finite() { cost } else { f64::INFINITY }
    }

    /// As [`Self::roll_out`] for the plan moved by `alpha` times the program's step, with the inputs of intervals that
    /// stick in the plan held within the friction that is there. The flag says whether that changed any.
    fn roll_out_held(&mut self, plan: &Trajectory, alpha: f64, z: &mut Trajectory) -> (f64, bool) {
        let (n, m) = (self.ocp.states(), self.ocp.inputs());
        let w = n + m;
        let (dt, substeps) = (self.ocp.dt, self.substeps());
        let mut held = false;
        for k in 0..z.steps() {
            let mut x = z.x(k).to_vec();
            let t = self.time(k);
            let interval = &self.intervals[k];
            let mut share = 1.0_f64;
            for i in 0..interval.modes.len() {
                if !interval.sticks(i) {
                    continue;
                }
                let row = &interval.rows[i * w..(i + 1) * w];
                let by_state: f64 = (0..n).map(|j| row[j] * (x[j] - plan.x(k)[j])).sum();
                let by_input: f64 = (0..m).map(|j| row[n + j] * alpha * self.qp.solution.du[k * m + j]).sum();
                let from = interval.signs[i] + by_state;
                let room = if by_input > 0.0 { 1.0 - from } else { -1.0 - from };
                if by_input != 0.0 && (by_input - room) * by_input.signum() > 0.0 {
                    share = share.min((room / by_input).clamp(0.0, 1.0));
                }
            }
            if share < 1.0 {
                held = true;
                for j in 0..m {
                    let b = self.ocp.input_bounds[j];
                    let v = plan.u(k)[j] + share * alpha * self.qp.solution.du[k * m + j];
                    z.u_mut(k)[j] = v.clamp(b.0, b.1);
                }
            }
            if !self.flow.advance(t, &mut x, z.u(k), dt, substeps, None, None) {
                return (f64::INFINITY, held);
            }
            z.x_mut(k + 1).copy_from_slice(&x);
        }
        let cost = self.cost(z);
        (if cost.is_finite() { cost } else { f64::INFINITY }, held)
    }

    /// Linearises along a roll-out; where the given switch sticks it is let slip in the given mode.
    fn linearise(&mut self, z: &Trajectory, slip: Option<(usize, FrictionMode)>) -> bool {
        let (n, m) = (self.ocp.states(), self.ocp.inputs());
        let w = n + m;
        let (dt, substeps) = (self.ocp.dt, self.substeps());
        self.lin.end.resize(z.steps() * n, 0.0);
        self.lin.jacobian.resize(z.steps() * n * w, 0.0);
        for k in 0..z.steps() {
            let t = self.time(k);
            let mut x = z.x(k).to_vec();
            let hold = slip.filter(|s| self.intervals[k].sticks(s.0));
            let jacobian = &mut self.lin.jacobian[k * n * w..(k + 1) * n * w];
            if !self.flow.advance(t, &mut x, z.u(k), dt, substeps, Some(jacobian), hold) {
                return false;
            }
            self.lin.end[k * n..(k + 1) * n].copy_from_slice(&x);
            if slip.is_none() {
                let interval = &mut self.intervals[k];
                interval.modes.clone_from(&self.flow.start_modes);
                interval.signs.clone_from(&self.flow.start_signs);
                interval.rows.clone_from(&self.flow.start_rows);
                interval.changes.clone_from(&self.flow.changes);
            }
        }
        true
    }

    fn solve_program(&mut self, z: &Trajectory) -> Result<QpStatus, MpcError> {
        self.qp.assemble(
            &mut self.ocp,
            self.k0,
            z,
            &self.lin,
            if self.lambda < MIN_PROXIMAL { 0.0 } else { self.lambda },
        );
        self.qp.solve()
    }

    fn moved(&self, z: &Trajectory, alpha: f64) -> Trajectory {
        let mut trial = z.moved(alpha, &self.qp.solution.dx, &self.qp.solution.du);
        trial.x_mut(0).copy_from_slice(z.x(0));
        trial.clamp_inputs(&self.ocp.input_bounds);
        trial
    }

    /// One program along `z` and the step it proposes, if the exact cost falls by it.
    fn improve(&mut self, z: &mut Trajectory, cost: &mut f64) -> Result<QpStatus, MpcError> {
        if !self.linearise(z, None) {
            return Ok(QpStatus::NotANumber);
        }
        let status = self.solve_program(z)?;
        if !status.is_usable() {
            return Ok(status);
        }
        for alpha in [1.0, 0.5, 0.25, 0.1, 0.03] {
            let mut trial = self.moved(z, alpha);
            let mut free = trial.clone();
            let (mut best, held) = self.roll_out_held(z, alpha, &mut trial);
            if held {
                let other = self.roll_out(&mut free);
                if other < best {
                    (best, trial) = (other, free);
                }
            }
            if best < *cost {
                (*z, *cost) = (trial, best);
                break;
            }
        }
        Ok(status)
    }

    /// Programs in which what sticks at the start is let slip; the cheapest roll-out is taken if it beats the plan.
    fn break_loose(&mut self, z: &mut Trajectory, cost: &mut f64) -> Result<(), MpcError> {
        if !self.linearise(z, None) {
            return Ok(());
        }
        let sticking: Vec<usize> = (0..self.flow.field.switches).filter(|&i| self.intervals[0].sticks(i)).collect();
        let base = z.clone();
        for i in sticking {
            for mode in [FrictionMode::Positive, FrictionMode::Negative] {
                if !self.linearise(&base, None) || !self.linearise(&base, Some((i, mode))) {
                    continue;
                }
                if !self.solve_program(&base)?.is_usable() {
                    continue;
                }
                for alpha in [1.0, 0.5, 0.25] {
                    let mut trial = self.moved(&base, alpha);
                    let mut value = self.roll_out(&mut trial);
                    if !value.is_finite() {
                        continue;
                    }
                    for _ in 0..2 {
                        self.improve(&mut trial, &mut value)?;
                    }
                    if value < *cost * (1.0 - self.settings.tolerance) {
                        (*z, *cost) = (trial, value);
                        break;
                    }
                }
            }
        }
        Ok(())
    }

    /// Moves the horizon by one interval; the last input is held for one more.
    fn shift(&mut self) {
        self.plan.shift();
        self.k0 += 1;
        let last = self.plan.steps() - 1;
        let mut end = self.plan.x(last).to_vec();
        let t = self.time(last);
        let (dt, substeps) = (self.ocp.dt, self.substeps());
        if self.flow.advance(t, &mut end, self.plan.u(last), dt, substeps, None, None) {
            self.plan.x_mut(last + 1).copy_from_slice(&end);
        }
    }

    /// Plans from the state `x`.
    fn solve_from(&mut self, x: &[f64]) -> Result<StepStatus, MpcError> {
        let mut z = self.plan.clone();
        z.x_mut(0).copy_from_slice(x);
        z.clamp_inputs(&self.ocp.input_bounds);
        let mut cost = self.roll_out(&mut z);
        let first = !std::mem::replace(&mut self.started, true);
        if first && let Some(mut sqp) = self.smooth.take() {
            let mut smooth = sqp.solve(x, &z)?.trajectory;
            let value = self.roll_out(&mut smooth);
            if value < cost {
                (z, cost) = (smooth, value);
            }
        }
        let limit = if first { self.settings.initial_iterations } else { self.settings.iterations };
        let mut status = QpStatus::Solved;
        for _ in 0..limit.max(1) {
            let before = cost;
            status = self.improve(&mut z, &mut cost)?;
            if !status.is_usable() || before - cost <= self.settings.tolerance * before.abs() {
                break;
            }
        }
        if status.is_usable() {
            self.break_loose(&mut z, &mut cost)?;
        }
        if cost.is_finite() {
            self.plan = z;
        }
        Ok(match status {
            _ if !cost.is_finite() => StepStatus::Fallback(FallbackReason::Linearisation),
            QpStatus::Solved | QpStatus::Relaxed => StepStatus::Solved,
            QpStatus::Inaccurate => StepStatus::Inaccurate,
            QpStatus::NotANumber => StepStatus::Fallback(FallbackReason::Linearisation),
            s => StepStatus::Fallback(FallbackReason::Qp(s)),
        })
    }
}

impl Controller for StickSlipController {
    fn step(&mut self, x: &[f64]) -> Result<Step, MpcError> {
        check_length("the measured state", x.len(), self.ocp.states())?;
        let start = Instant::now();
        self.failures.believe(x);
        let limits = std::mem::take(&mut self.limits);
        let qp = &self.settings.qp;
        self.qp.set_limits(qp.max_iterations.min(limits.iterations), qp.time_limit.min(limits.time))?;
        let status = match FallbackReason::of_measurement(x) {
            None => self.solve_from(x)?,
            Some(reason) => StepStatus::Fallback(reason),
        };
        let mut u = self.plan.u(0).to_vec();
        let source = if matches!(status, StepStatus::Fallback(_)) {
            self.failures.decide(&self.plan, &self.ocp.input_bounds, &mut u)
        } else {
            self.failures.solved(self.plan.steps());
            InputSource::Program
        };
        self.failures.shift();
        self.shift();
        Ok(Step { u, status, source, timings: Timings { qp: start.elapsed().as_secs_f64(), ..Timings::default() } })
    }

    fn ocp(&self) -> &Ocp {
        &self.ocp
    }

    fn set_start(&mut self, k0: usize) {
        self.k0 = k0;
    }

    fn limit_next_step(&mut self, limits: StepLimits) {
        self.limits = limits;
    }
}
