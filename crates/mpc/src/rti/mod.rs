//! Real-time iteration: one quadratic program per sample.
//!
//! Preparation, before the measurement: linearize along the shifted trajectory and fill the program. Feedback, after it:
//! linearize the first interval at the measured state, solve, apply the first input. A sample without a solution gets the
//! input of the [`FailurePolicy`](crate::controller::FailurePolicy).

mod advanced_step;
mod settings;
mod tangential_predictor;

pub use settings::{Horizon, Preparation, RtiSettings};

use crate::controller::{
    Controller, Failures, FallbackReason, InputSource, SolverEffort, Step, StepLimits, StepStatus, Timings, rest_input,
};
use crate::dynamics::Dynamics;
use crate::error::{MpcError, check_length};
use crate::ocp::{Bounds, Ocp};
use crate::qp::{Qp, QpStatus};
use crate::trajectory::PlannedTrajectory;
use crate::transcription::{ShootingLinearization, Transcription};
use std::time::Instant;
use tangential_predictor::{Tangent, first_hessian};

/// Violation of a hard bound, in units of its state's scale, above which a sample counts as infeasible. A trajectory that
/// is linearized once per sample misses its bounds by a little.
const HARD_TOLERANCE: f64 = 1e-3;
/// Largest change, in units of state scales and input trusts, after which further iterations of a sample change nothing.
const SETTLED: f64 = 1e-7;
/// Samples in a row without a solution of their program after which the trajectory is started again.
const PATIENCE: usize = 3;

/// The controller.
pub struct Rti {
    problem: Transcription,
    settings: RtiSettings,
    qp: Qp,
    lin: ShootingLinearization,
    trajectory: PlannedTrajectory,
    /// Trajectory at work in the feedback; a failed one leaves the plan as it is.
    work: PlannedTrajectory,
    /// Candidate of the guarded step.
    trial: PlannedTrajectory,
    step: Step,
    failures: Failures,
    limits: StepLimits,
    prepared: bool,
    /// Time taken by the preparation, s.
    prepare_seconds: f64,
    /// The trajectory is no good to linearize along.
    lost: bool,
    /// Gains and status of a program solved ahead.
    tangent: Option<(Tangent, StepStatus)>,
}

impl Rti {
    /// A controller that starts from `trajectory` (a plan, or [`PlannedTrajectory::constant`]).
    ///
    /// # Errors
    /// If the problem contradicts itself, the dynamics or the trajectory, or a setting is out of its range.
    pub fn new(
        dynamics: Box<dyn Dynamics>,
        ocp: Ocp,
        trajectory: PlannedTrajectory,
        settings: RtiSettings,
    ) -> Result<Self, MpcError> {
        let mut problem = Transcription::new(dynamics, ocp)?;
        problem.check_trajectory(&trajectory)?;
        // A guarded step that finds nothing better keeps the trajectory as it is: its inputs must be ones that can be applied.
        let mut trajectory = trajectory;
        trajectory.clamp_inputs(&problem.ocp.input_bounds);
        settings.check(&problem.ocp)?;
        let rest = rest_input(&settings.rest_input, &problem.ocp.input_bounds)?;
        if let Some(w) = settings.smoothing {
            problem.dynamics.set_smoothing(w);
        }
        problem.choose_substeps(&trajectory);
        let steps = trajectory.steps();
        let qp = Qp::new(&problem.ocp, steps, problem.shooter.closure(), settings.qp);
        Ok(Self {
            failures: Failures::new(settings.policy.clone(), rest, problem.ocp.states(), steps),
            step: Step::undecided(problem.ocp.inputs()),
            problem,
            settings,
            qp,
            lin: ShootingLinearization::default(),
            work: trajectory.clone(),
            trial: trajectory.clone(),
            trajectory,
            limits: StepLimits::default(),
            prepared: false,
            prepare_seconds: 0.0,
            lost: false,
            tangent: None,
        })
    }

    /// The trajectory that the next input comes from.
    pub fn trajectory(&self) -> &PlannedTrajectory {
        &self.trajectory
    }

    /// The problem.
    pub fn ocp(&self) -> &Ocp {
        &self.problem.ocp
    }

    /// Grid point of the run at which the horizon starts.
    pub fn start(&self) -> usize {
        self.problem.k0
    }

    /// Number of integration steps per interval in use.
    pub fn substeps(&self) -> usize {
        self.problem.substeps
    }

    /// Sets the grid point of the run at which the horizon starts (time and references follow it).
    pub fn set_start(&mut self, k0: usize) {
        self.problem.k0 = k0;
        self.prepared = false;
    }

    /// Limits the next feedback alone, on top of the settings.
    pub fn limit_next_step(&mut self, limits: StepLimits) {
        self.limits = limits;
    }

    /// Gives the live parameters of the model these values at every grid point, from the next preparation on.
    ///
    /// # Errors
    /// If their number is not that of the live parameters.
    pub fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        self.prepared = false;
        self.problem.set_parameters(parameters)
    }

    /// Replaces the references, from the next preparation on.
    ///
    /// # Errors
    /// If a row has the wrong length or there is none and the cost needs references.
    pub fn set_references(&mut self, references: Vec<Vec<f64>>) -> Result<(), MpcError> {
        self.change(|ocp| ocp.references = references)
    }

    /// Replaces the value of target `index` of the problem's list, from the next preparation on.
    ///
    /// # Errors
    /// If there is no such target or the value is not finite.
    pub fn set_target(&mut self, index: usize, value: f64) -> Result<(), MpcError> {
        let found = self.problem.ocp.targets.len();
        if index >= found {
            return Err(MpcError::Length { what: "the list of targets", found, expected: index + 1 });
        }
        self.change(|ocp| ocp.targets[index].value = value)
    }

    /// Replaces the bounds of states and inputs, from the next preparation on. Cheap when the same bounds are finite as
    /// before, else the program is laid out anew.
    ///
    /// # Errors
    /// If the bounds contradict themselves or the number of states and inputs.
    pub fn set_bounds(&mut self, states: Vec<Bounds>, inputs: Vec<(f64, f64)>) -> Result<(), MpcError> {
        self.change(|ocp| {
            ocp.state_bounds = states;
            ocp.input_bounds = inputs;
        })
    }

    /// Changes the problem; a change that contradicts it is undone.
    fn change(&mut self, change: impl FnOnce(&mut Ocp)) -> Result<(), MpcError> {
        let relaid = self.problem.change(change)?;
        self.prepared = false;
        self.trajectory.clamp_inputs(&self.problem.ocp.input_bounds);
        if self.settings.rest_input.is_empty() {
            self.failures.set_rest(rest_input(&[], &self.problem.ocp.input_bounds)?);
        }
        if relaid {
            self.lay_out();
        }
        Ok(())
    }

    fn lay_out(&mut self) {
        let steps = self.trajectory.steps();
        self.qp = Qp::new(&self.problem.ocp, steps, self.problem.shooter.closure(), self.settings.qp);
    }

    fn used_up(&self) -> bool {
        match self.settings.horizon {
            Horizon::Receding => false,
            Horizon::Shrinking { min_steps } => self.trajectory.steps() < min_steps.max(1),
        }
    }

    /// Everything that does not need the measurement. Called by [`Rti::feedback`] when it has not been before.
    ///
    /// # Errors
    /// If a setting of the programs is out of its range.
    pub fn prepare(&mut self) -> Result<(), MpcError> {
        if self.prepared || self.used_up() {
            return Ok(());
        }
        let start = Instant::now();
        if self.qp.steps() != self.trajectory.steps() {
            self.lay_out();
        }
        self.tangent = None;
        let ahead = match self.settings.preparation {
            Preparation::Linearize => None,
            Preparation::AdvancedStep { programs } | Preparation::AdvancedStepTangential { programs } => {
                self.solve_ahead(programs, start)?
            }
        };
        self.fill();
        if let (Some(status), Preparation::AdvancedStepTangential { .. }) = (ahead, self.settings.preparation) {
            let first = first_hessian(&mut self.problem.ocp, self.problem.k0, &self.trajectory);
            let (program, z) = self.qp.stage_program();
            self.tangent = Tangent::of(program, z, &self.lin.jacobian, &first).map(|t| (t, status));
        }
        self.work.copy_from(&self.trajectory);
        self.trial.copy_from(&self.trajectory);
        self.prepare_seconds = start.elapsed().as_secs_f64();
        self.prepared = true;
        Ok(())
    }

    /// Linearizes along the trajectory and fills the program.
    fn fill(&mut self) {
        let (k0, steps) = (self.problem.k0, self.trajectory.steps());
        self.problem.linearize(&self.trajectory, 0, steps, &mut self.lin);
        self.qp.assemble(&mut self.problem.ocp, k0, &self.trajectory, &self.lin, self.settings.proximal);
    }

    /// The input for the measured state `x`, NaN where nothing is known. Does not move the horizon: [`Rti::shift`] does.
    ///
    /// # Errors
    /// If `x` has the wrong length.
    pub fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        check_length("the measured state", x.len(), self.problem.ocp.states())?;
        let limits = std::mem::take(&mut self.limits);
        self.failures.believe(x);
        if self.used_up() {
            self.step.source =
                self.failures.play_out(&self.trajectory, &self.problem.ocp.input_bounds, &mut self.step.u);
            self.step.status = StepStatus::PlayedOut;
            self.step.residual = None;
            self.step.timings = Timings::default();
            self.step.effort = SolverEffort::default();
            return Ok(&self.step);
        }
        self.prepare()?;
        self.prepared = false;
        let start = Instant::now();
        let mut timings = Timings { linearize: self.prepare_seconds, ..Timings::default() };
        let mut source = InputSource::Program;
        let result = match FallbackReason::of_measurement(x) {
            Some(reason) => Err(reason),
            None => match self.move_along(x) {
                Some(status) => {
                    source = InputSource::Tangent;
                    Ok(status)
                }
                None => self.solve_from(x, limits, start, &mut timings)?,
            },
        };
        match result {
            Ok(status) => {
                self.step.status = status;
                self.step.source = source;
                self.step.u.copy_from_slice(self.trajectory.u(0));
                self.step.residual = (source == InputSource::Program).then(|| self.qp.residual());
                self.failures.solved(self.trajectory.steps());
                self.lost = false;
            }
            Err(reason) => {
                let bounds = &self.problem.ocp.input_bounds;
                self.step.status = StepStatus::Fallback(reason);
                self.step.residual = None;
                self.step.source = self.failures.decide(&self.trajectory, bounds, &mut self.step.u);
                self.lost = match reason {
                    FallbackReason::LostSample | FallbackReason::Measurement => false,
                    FallbackReason::Linearization | FallbackReason::Cost | FallbackReason::Qp(QpStatus::Failed) => true,
                    FallbackReason::TimeLimit | FallbackReason::Qp(_) => self.failures.in_a_row() >= PATIENCE,
                };
            }
        }
        timings.rest = start.elapsed().as_secs_f64() - timings.qp;
        self.step.timings = timings;
        self.step.effort = self.qp.take_effort();
        Ok(&self.step)
    }

    /// Solves one program, and more of them as far as the settings say. The new trajectory is taken over on success.
    fn solve_from(
        &mut self,
        x: &[f64],
        limits: StepLimits,
        start: Instant,
        timings: &mut Timings,
    ) -> Result<Result<StepStatus, FallbackReason>, MpcError> {
        let budget = self.settings.time_limit.min(limits.time) - self.prepare_seconds;
        let max_iterations = self.settings.qp.max_iterations.min(limits.iterations);
        let (k0, lambda) = (self.problem.k0, self.settings.proximal);
        self.work.x_mut(0).copy_from_slice(x);
        let mut outcome = Err(FallbackReason::TimeLimit);
        let mut last = 0.0;
        for iteration in 0..self.settings.iterations {
            let started = start.elapsed().as_secs_f64();
            if iteration > 0 && budget - started < last {
                break;
            }
            if iteration == 0 {
                self.problem.linearize(&self.work, 0, 1, &mut self.lin);
                self.qp.update_first_interval(&mut self.problem.ocp, k0, &self.work, &self.lin);
            } else {
                self.problem.linearize(&self.work, 0, self.work.steps(), &mut self.lin);
                self.qp.assemble(&mut self.problem.ocp, k0, &self.work, &self.lin, lambda);
            }
            let ready = start.elapsed().as_secs_f64();
            let left = budget - ready;
            if left <= 0.0 {
                break;
            }
            self.qp.set_limits(max_iterations, self.settings.qp.time_limit.min(left))?;
            let status = self.qp.solve()?;
            let now = start.elapsed().as_secs_f64();
            timings.qp += now - ready;
            let solved = match status {
                QpStatus::Solved | QpStatus::Relaxed => Ok(StepStatus::Solved),
                QpStatus::Inaccurate => Ok(StepStatus::Inaccurate),
                QpStatus::NotANumber => Err(FallbackReason::Linearization),
                QpStatus::Limit if now >= budget => Err(FallbackReason::TimeLimit),
                s => Err(FallbackReason::Qp(s)),
            };
            if solved.is_err() && iteration > 0 {
                break;
            }
            outcome = solved;
            if outcome.is_err() {
                break;
            }
            if !self.advance() {
                break;
            }
            last = start.elapsed().as_secs_f64() - started;
        }
        let outcome = match outcome {
            Ok(_) if !self.work.is_finite() => Err(FallbackReason::Linearization),
            Ok(_) if !self.problem.ocp.cost(k0, &self.work).is_finite() => Err(FallbackReason::Cost),
            Ok(_) if self.problem.ocp.hard_violation(self.problem.k0, &self.work) > HARD_TOLERANCE => {
                Ok(StepStatus::Infeasible)
            }
            other => other,
        };
        if outcome.is_ok() {
            std::mem::swap(&mut self.trajectory, &mut self.work);
        }
        Ok(outcome)
    }

    /// Takes the step of the program; whether it changes anything.
    fn advance(&mut self) -> bool {
        let ocp = &self.problem.ocp;
        let (dx, du) = (&self.qp.solution.dx, &self.qp.solution.du);
        let (n, m) = (ocp.states(), ocp.inputs());
        let moves = dx.iter().enumerate().any(|(i, d)| d.abs() > SETTLED * ocp.state_scale[i % n])
            || du.iter().enumerate().any(|(j, d)| d.abs() > SETTLED * ocp.input_trust[j % m]);
        if !self.settings.guarded {
            self.work.add(1.0, dx, du);
            self.work.clamp_inputs(&self.problem.ocp.input_bounds);
            return moves;
        }
        let hard = self.settings.qp.hard_weight;
        let weight = self.problem.penalty_weight(&self.qp.solution.multipliers);
        let before = self.problem.merit_with(&self.work, &self.lin.end, hard).value(weight);
        for alpha in [1.0, 0.5, 0.25, 0.1] {
            self.trial.copy_from(&self.work);
            self.trial.add(alpha, &self.qp.solution.dx, &self.qp.solution.du);
            self.trial.clamp_inputs(&self.problem.ocp.input_bounds);
            if self.problem.merit(&self.trial, hard).value(weight) < before {
                std::mem::swap(&mut self.work, &mut self.trial);
                return moves;
            }
        }
        false
    }

    /// Moves the horizon by one interval.
    pub fn shift(&mut self) {
        self.prepared = false;
        self.failures.shift();
        self.problem.predict(&mut self.failures.x, &self.step.u);
        if self.trajectory.steps() == 0 {
            return;
        }
        match self.settings.horizon {
            Horizon::Shrinking { .. } => {
                self.trajectory.drop_first();
                self.problem.ocp.merge_shared_inputs(&mut self.trajectory);
                self.problem.ocp.steps = self.trajectory.steps();
                self.problem.k0 += 1;
            }
            Horizon::Receding => {
                self.problem.ocp.move_on(&mut self.trajectory);
                self.problem.k0 += 1;
                self.problem.extend_last(&mut self.trajectory);
            }
        }
        if self.lost || self.failures.used_up() {
            self.restart();
        }
    }

    /// Replaces the states of the trajectory by those that follow from the state as far as known and the planned inputs, or
    /// the rest input when these have been used up; where that leads to no numbers, by the state itself.
    fn restart(&mut self) {
        if self.failures.x.iter().any(|v| !v.is_finite()) {
            return;
        }
        let steps = self.trajectory.steps();
        if self.failures.plan(&self.trajectory).is_none() {
            for k in 0..steps {
                self.trajectory.u_mut(k).copy_from_slice(self.failures.rest());
            }
        }
        self.trajectory.x_mut(0).copy_from_slice(&self.failures.x);
        self.problem.roll_out(&mut self.trajectory);
        if !self.trajectory.is_finite() {
            for k in 0..=steps {
                self.trajectory.x_mut(k).copy_from_slice(&self.failures.x);
            }
        }
    }
}

impl Controller for Rti {
    fn prepare(&mut self) -> Result<(), MpcError> {
        Rti::prepare(self)
    }
    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        Rti::feedback(self, x)
    }
    fn shift(&mut self) {
        Rti::shift(self);
    }
    fn plan(&self) -> &PlannedTrajectory {
        &self.trajectory
    }
    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError> {
        Rti::change(self, change)
    }
    fn ocp(&self) -> &Ocp {
        Rti::ocp(self)
    }
    fn set_start(&mut self, k0: usize) {
        Rti::set_start(self, k0);
    }
    fn limit_next_step(&mut self, limits: StepLimits) {
        Rti::limit_next_step(self, limits);
    }
    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        Rti::set_parameters(self, parameters)
    }
}
