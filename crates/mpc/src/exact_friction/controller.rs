//! Receding-horizon control on the exact stick–slip flow.

use super::flow::StickSlipFlow;
use super::roll_out::ExactProblem;
use super::settings::StickSlipSettings;
use super::switched_field::SwitchedField;
use crate::controller::{
    Controller, Failures, FallbackReason, InputSource, SolverEffort, Step, StepLimits, StepStatus, Timings, rest_input,
};
use crate::dynamics::{Dynamics, SymbolicDynamics};
use crate::error::{MpcError, check_flag, check_length};
use crate::ocp::Ocp;
use crate::qp::{Qp, QpStatus};
use crate::sqp::{Sqp, SqpSettings};
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{Shooter, ShootingLinearization, Transcription};
use bracketry_sim::ModeChange;
use bracketry_system::System;
use std::time::Instant;

/// A controller for systems with dry friction that plans on the exact stick–slip flow.
///
/// Every plan is a roll-out of the exact flow from the measured state, so none rests on creep that does not exist. A
/// quadratic program along it, with the derivative of the flow across events, proposes a step; it is taken when the exact
/// cost falls. Where the plan sticks, the derivative is zero and promises nothing beyond the friction that holds: inputs
/// are moved there no further than that. So no derivative leads out of sticking. Therefore, where something sticks at
/// the start, a smoothed program tells in which direction it wants to move, a second one with that slip imposed tells how
/// hard to push, and the push is taken when its exact roll-out costs less. Nothing sticks or breaks loose but for a gain.
///
/// ```
/// use bracketry_mpc::{Controller, CostFunction, CostKind, Ocp, StickSlipController, PlannedTrajectory};
/// use bracketry_mpc::exact_friction::StickSlipSettings;
/// use bracketry_system::System;
/// let block = System::parse("block.toml", r#"
///     states = ["x", "v"]
///     inputs = ["a"]
///     dynamics = { x = "v", v = "a - sign(v)" }
/// "#).unwrap();
/// let mut ocp = Ocp::new(2, 1, 20, 0.05);
/// ocp.stage = Some(CostFunction::parse(&block, CostKind::Stage, &[], "x^2 + 1e-3*a^2").unwrap());
/// let guess = PlannedTrajectory::constant(20, &[-1.0, 0.0], &[0.0]);
/// let mut controller = StickSlipController::new(&block, ocp, guess, StickSlipSettings::default()).unwrap();
/// assert!(controller.step(&[-1.0, 0.0]).unwrap().u[0] > 1.0, "only more than friction moves the block");
/// ```
pub struct StickSlipController {
    problem: ExactProblem,
    qp: Qp,
    settings: StickSlipSettings,
    plan: PlannedTrajectory,
    step: Step,
    failures: Failures,
    limits: StepLimits,
    lambda: f64,
    started: bool,
    /// What the solutions with smoothed friction took, for the next sample's effort.
    smoothed: SolverEffort,
    dynamics: SymbolicDynamics,
    smooth: Option<Transcription>,
    smooth_lin: ShootingLinearization,
    /// The solution of the problem with the widest smoothing, where it is there before the first plan is made.
    widest: Option<PlannedTrajectory>,
    start: Instant,
    qp_seconds: f64,
}

/// Smallest proximal weight that is used; below it the term is left out.
const MIN_PROXIMAL: f64 = 1e-4;
/// Programs that refine a push before it is compared with the plan.
const PUSH_ITERATIONS: usize = 2;

impl StickSlipController {
    /// A controller for the system, with `guess` as the first inputs. The interval is integrated by the classical
    /// Runge–Kutta method between events, in the problem's number of substeps.
    ///
    /// # Errors
    /// If the problem contradicts itself, the system, the guess or the settings.
    pub fn new(
        system: &System,
        ocp: Ocp,
        guess: PlannedTrajectory,
        settings: StickSlipSettings,
    ) -> Result<Self, MpcError> {
        settings.check()?;
        let live: Vec<&str> = settings.live_parameters.iter().map(String::as_str).collect();
        let dynamics = SymbolicDynamics::with_live_parameters(system, &live)?;
        let flow = StickSlipFlow::new(SwitchedField::new(system, &live, settings.rounding)?);
        let switches = flow.field.switches;
        settings.failure.check(ocp.states(), ocp.inputs())?;
        let mut smooth = Transcription::new(Box::new(dynamics.clone()), ocp.clone())?;
        smooth.check_trajectory(&guess)?;
        let rest = rest_input(&settings.rest_input, &ocp.input_bounds)?;
        let failures = Failures::new(settings.failure.clone(), rest, ocp.states(), guess.steps());
        let qp = Qp::new(&ocp, ocp.steps, smooth.shooter.closure(), settings.qp);
        let width = settings.smoothing.first().copied().filter(|_| switches > 0);
        if let Some(w) = width {
            smooth.dynamics.set_smoothing(w);
        }
        Ok(Self {
            qp,
            smooth: width.map(|_| smooth),
            smooth_lin: ShootingLinearization::default(),
            widest: None,
            step: Step::undecided(ocp.inputs()),
            plan: guess,
            failures,
            limits: StepLimits::default(),
            lambda: 0.0,
            started: false,
            smoothed: SolverEffort::default(),
            problem: ExactProblem::new(ocp, flow, settings.qp.hard_weight),
            dynamics,
            settings,
            start: Instant::now(),
            qp_seconds: 0.0,
        })
    }

    /// Gives the live parameters these values at every grid point, for instance those of an estimator.
    ///
    /// # Errors
    /// If their number is not that of the live parameters.
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        check_length("the parameters", parameters.len(), self.settings.live_parameters.len())?;
        self.problem.ocp.parameters = vec![parameters.to_vec()];
        match &mut self.smooth {
            Some(smooth) => smooth.set_parameters(parameters),
            None => Ok(()),
        }
    }

    /// The trajectory that the next input comes from.
    pub fn plan(&self) -> &PlannedTrajectory {
        &self.plan
    }

    /// Makes the first plan, from the state `x`, which otherwise the first sample does.
    ///
    /// # Errors
    /// If `x` has the wrong length.
    pub fn plan_from(&mut self, x: &[f64]) -> Result<&PlannedTrajectory, MpcError> {
        check_length("the initial state", x.len(), self.problem.ocp.states())?;
        self.start = Instant::now();
        if x.iter().all(|v| v.is_finite()) {
            self.solve_from(x)?;
        }
        Ok(&self.plan)
    }

    /// The plan from the state `x` with friction smoothed to the first of the widths, which is one of those that the first plan is
    /// chosen from; the guess where there are no widths or no friction.
    ///
    /// # Errors
    /// If `x` has the wrong length.
    pub(crate) fn smoothed_plan(&mut self, x: &[f64]) -> Result<PlannedTrajectory, MpcError> {
        check_length("the initial state", x.len(), self.problem.ocp.states())?;
        let (guess, _) = self.guess_from(x);
        let Some(&width) = self.settings.smoothing.first().filter(|_| self.smooth.is_some()) else { return Ok(guess) };
        let plan = self.solve_smoothed(width, &guess)?;
        self.widest = Some(plan.clone());
        Ok(plan)
    }

    /// The inputs of the plan from the state `x`, with their cost.
    fn guess_from(&mut self, x: &[f64]) -> (PlannedTrajectory, f64) {
        let mut z = self.plan.clone();
        z.x_mut(0).copy_from_slice(x);
        z.clamp_inputs(&self.problem.ocp.input_bounds);
        let cost = self.problem.roll_out(&mut z);
        (z, cost)
    }

    /// Settings of the solutions with smoothed friction.
    fn smoothed_settings(&self) -> SqpSettings {
        SqpSettings {
            qp: self.settings.qp,
            max_iterations: 50,
            stop: self.settings.stop.clone(),
            ..SqpSettings::default()
        }
    }

    /// The solution with friction smoothed to this width.
    fn solve_smoothed(&mut self, width: f64, guess: &PlannedTrajectory) -> Result<PlannedTrajectory, MpcError> {
        let mut dynamics = self.dynamics.clone();
        dynamics.set_smoothing(width);
        let sqp = Sqp::new(Box::new(dynamics), self.problem.ocp.clone(), self.smoothed_settings())?;
        self.solve_with(sqp, guess)
    }

    /// The solution of another solver, from where the horizon starts now.
    fn solve_with(&mut self, mut sqp: Sqp, guess: &PlannedTrajectory) -> Result<PlannedTrajectory, MpcError> {
        sqp.set_start(self.problem.k0);
        let solution = sqp.solve(guess.x(0), guess)?;
        self.smoothed += solution.effort();
        Ok(solution.trajectory)
    }

    /// The changes of mode along the plan, in order of time; empty where the flow fails.
    pub fn mode_changes(&mut self) -> Vec<ModeChange> {
        if !self.problem.linearize(&self.plan) {
            return Vec::new();
        }
        self.problem.intervals.iter().flat_map(|i| &i.changes).copied().collect()
    }

    fn solve_program(&mut self, z: &PlannedTrajectory, smooth: bool) -> Result<QpStatus, MpcError> {
        let lin = if smooth { &self.smooth_lin } else { &self.problem.lin };
        let proximal = if self.lambda < MIN_PROXIMAL { 0.0 } else { self.lambda };
        let start = Instant::now();
        self.qp.assemble(&mut self.problem.ocp, self.problem.k0, z, lin, proximal);
        let status = self.qp.solve();
        self.qp_seconds += start.elapsed().as_secs_f64();
        status
    }

    /// `z` with the inputs moved by `alpha` times the step of the program.
    fn moved(&self, z: &PlannedTrajectory, alpha: f64) -> PlannedTrajectory {
        let mut trial = z.moved(alpha, &self.qp.solution.dx, &self.qp.solution.du);
        trial.x_mut(0).copy_from_slice(z.x(0));
        trial.clamp_inputs(&self.problem.ocp.input_bounds);
        trial
    }

    /// One program along `z`; the step it proposes is taken, shortened if need be, where the exact cost falls.
    fn improve(&mut self, z: &mut PlannedTrajectory, cost: &mut f64) -> Result<QpStatus, MpcError> {
        if !self.problem.linearize(z) {
            return Ok(QpStatus::NotANumber);
        }
        let status = self.solve_program(z, false)?;
        if !status.is_usable() {
            return Ok(status);
        }
        for alpha in [1.0, 0.5, 0.25, 0.1, 0.03] {
            let mut trial = self.moved(z, alpha);
            let mut free = trial.clone();
            let (mut value, held) = self.problem.roll_out_held(z, &mut trial);
            if held {
                let other = self.problem.roll_out(&mut free);
                if other < value {
                    (value, trial) = (other, free);
                }
            }
            if value < *cost {
                (*z, *cost) = (trial, value);
                self.lambda = if alpha > 0.3 { self.lambda / 5.0 } else { (2.0 * self.lambda).max(MIN_PROXIMAL) };
                return Ok(status);
            }
        }
        self.lambda = (5.0 * self.lambda).clamp(MIN_PROXIMAL, 1e3);
        Ok(status)
    }

    /// Lets slip what sticks at the start, if that pays.
    fn break_loose(&mut self, z: &mut PlannedTrajectory, cost: &mut f64) -> Result<(), MpcError> {
        if self.smooth.is_none() || !self.problem.sticks_at_start(z) || !self.problem.linearize(z) {
            return Ok(());
        }
        let Some(smooth) = &mut self.smooth else { return Ok(()) };
        smooth.k0 = self.problem.k0;
        smooth.choose_substeps(z);
        smooth.linearize(z, 0, z.steps(), &mut self.smooth_lin);
        if !self.solve_program(z, true)?.is_usable() {
            return Ok(());
        }
        let mut push = self.moved(z, 1.0);
        let mut value = self.problem.roll_out(&mut push);
        let directions = self.problem.directions(z, &self.qp.solution.dx);
        if directions.iter().any(Option::is_some)
            && self.problem.linearize_released(z, &directions)
            && self.solve_program(z, false)?.is_usable()
        {
            for alpha in [1.0, 0.5] {
                let mut trial = self.moved(z, alpha);
                let other = self.problem.roll_out(&mut trial);
                if other < value {
                    (push, value) = (trial, other);
                }
            }
        }
        if !value.is_finite() {
            return Ok(());
        }
        for _ in 0..PUSH_ITERATIONS {
            if self.out_of_time() {
                break;
            }
            self.improve(&mut push, &mut value)?;
        }
        if value < *cost - self.settings.tolerance * cost.abs() {
            (*z, *cost) = (push, value);
        }
        Ok(())
    }

    /// The best first plan: of the guess, and of solutions of smoothed problems, by their exact roll-outs.
    fn first_plan(&mut self, z: &mut PlannedTrajectory, cost: &mut f64) -> Result<(), MpcError> {
        if self.smooth.is_none() {
            return Ok(());
        }
        let guess = z.clone();
        let mut candidates: Vec<PlannedTrajectory> = Vec::new();
        // Whole steps find good solutions through states that a merit function forbids; the guarded iteration converges where
        // they do not.
        let mut solved = self.widest.take();
        for w in self.settings.smoothing.clone() {
            let last = match solved.take() {
                Some(first) => first,
                None => self.solve_smoothed(w, candidates.last().unwrap_or(&guess))?,
            };
            candidates.push(last);
        }
        let guarded = SqpSettings {
            smoothing: self.settings.smoothing.clone(),
            filter_iterations: 0,
            ..self.smoothed_settings()
        };
        let sqp = Sqp::new(Box::new(self.dynamics.clone()), self.problem.ocp.clone(), guarded)?;
        candidates.push(self.solve_with(sqp, &guess)?);
        for mut candidate in candidates {
            let value = self.problem.roll_out(&mut candidate);
            if value < *cost {
                (*z, *cost) = (candidate, value);
            }
        }
        Ok(())
    }

    fn out_of_time(&self) -> bool {
        self.start.elapsed().as_secs_f64() >= self.limits.time
    }

    /// Plans from the state `x`.
    fn solve_from(&mut self, x: &[f64]) -> Result<StepStatus, MpcError> {
        let (mut z, mut cost) = self.guess_from(x);
        let first = !std::mem::replace(&mut self.started, true);
        if first {
            self.first_plan(&mut z, &mut cost)?;
        }
        let limit = if first { self.settings.initial_iterations } else { self.settings.iterations };
        let mut status = QpStatus::Solved;
        for _ in 0..limit.max(1) {
            check_flag(&self.settings.stop)?;
            let before = cost;
            status = self.improve(&mut z, &mut cost)?;
            if !status.is_usable() || before - cost <= self.settings.tolerance * before.abs() || self.out_of_time() {
                break;
            }
        }
        if status.is_usable() && !self.out_of_time() {
            self.break_loose(&mut z, &mut cost)?;
        }
        let violation = self.problem.ocp.hard_violation(self.problem.k0, &z);
        if cost.is_finite() {
            self.plan = z;
        }
        Ok(match status {
            _ if !cost.is_finite() => StepStatus::Fallback(FallbackReason::Linearization),
            s if s.is_usable() && violation > HARD_TOLERANCE => StepStatus::Infeasible,
            QpStatus::Solved | QpStatus::Relaxed => StepStatus::Solved,
            QpStatus::Inaccurate => StepStatus::Inaccurate,
            QpStatus::NotANumber => StepStatus::Fallback(FallbackReason::Linearization),
            QpStatus::Limit if self.out_of_time() => StepStatus::Fallback(FallbackReason::TimeLimit),
            s => StepStatus::Fallback(FallbackReason::Qp(s)),
        })
    }
}

/// Violation of a hard bound, in units of its scale, above which a sample counts as infeasible.
const HARD_TOLERANCE: f64 = 1e-3;

impl Controller for StickSlipController {
    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        check_length("the measured state", x.len(), self.problem.ocp.states())?;
        (self.start, self.qp_seconds) = (Instant::now(), 0.0);
        self.failures.believe(x);
        let qp = &self.settings.qp;
        let (iterations, time) = (self.limits.iterations, self.limits.time);
        self.qp.set_limits(qp.max_iterations.min(iterations), qp.time_limit.min(time))?;
        let status = match FallbackReason::of_measurement(x) {
            None => self.solve_from(x)?,
            Some(reason) => StepStatus::Fallback(reason),
        };
        self.limits = StepLimits::default();
        self.step.status = status;
        self.step.source = if matches!(status, StepStatus::Fallback(_)) {
            self.failures.decide(&self.plan, &self.problem.ocp.input_bounds, &mut self.step.u)
        } else {
            self.step.u.copy_from_slice(self.plan.u(0));
            self.failures.solved(self.plan.steps());
            InputSource::Program
        };
        let rest = self.start.elapsed().as_secs_f64() - self.qp_seconds;
        self.step.timings = Timings { linearize: 0.0, qp: self.qp_seconds, rest };
        self.step.effort = std::mem::take(&mut self.smoothed);
        self.step.effort += self.qp.take_effort();
        Ok(&self.step)
    }

    /// Moves the horizon by one interval; the last input is held for one more.
    fn shift(&mut self) {
        self.failures.shift();
        self.problem.ocp.move_on(&mut self.plan);
        self.problem.k0 += 1;
        let last = self.plan.steps() - 1;
        self.problem.advance(&mut self.plan, last);
    }

    fn plan(&self) -> &PlannedTrajectory {
        &self.plan
    }

    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError> {
        let mut ocp = self.problem.ocp.clone();
        change(&mut ocp);
        ocp.check(self.problem.ocp.model_states(), self.plan.inputs())?;
        for row in &ocp.parameters {
            check_length("a row of parameters", row.len(), self.settings.live_parameters.len())?;
        }
        if ocp.layout_of_bounds() != self.problem.ocp.layout_of_bounds() {
            let shooter = Shooter::of_problem(&self.dynamics, &ocp);
            self.qp = Qp::new(&ocp, ocp.steps, shooter.closure(), self.settings.qp);
        }
        if let Some(smooth) = &mut self.smooth {
            smooth.ocp = ocp.clone();
        }
        self.problem.ocp = ocp;
        self.plan.clamp_inputs(&self.problem.ocp.input_bounds);
        Ok(())
    }

    fn ocp(&self) -> &Ocp {
        &self.problem.ocp
    }

    fn set_start(&mut self, k0: usize) {
        self.problem.k0 = k0;
    }

    fn limit_next_step(&mut self, limits: StepLimits) {
        self.limits = limits;
    }

    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        StickSlipController::set_parameters(self, parameters)
    }
}
