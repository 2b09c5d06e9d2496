//! Sequential quadratic programming at every sample.

use super::solution::SolveStatus;
use super::solver::Sqp;
use crate::controller::{
    Controller, FailurePolicy, Failures, FallbackReason, InputSource, SolverEffort, Step, StepLimits, StepStatus,
    Timings, rest_input,
};
use crate::error::{MpcError, check_length};
use crate::ocp::Ocp;
use crate::qp::QpStatus;
use crate::trajectory::PlannedTrajectory;

/// Solves every sample to convergence, from the shifted solution of the last.
pub struct SqpController {
    sqp: Sqp,
    trajectory: PlannedTrajectory,
    k: usize,
    step: Step,
    failures: Failures,
    limits: StepLimits,
}

impl SqpController {
    /// A controller that starts from the guess and rests at zero (or the input closest to it) when a plan is used up.
    pub fn new(sqp: Sqp, guess: PlannedTrajectory) -> Self {
        let rest = sqp.ocp().input_bounds.iter().map(|b| 0f64.clamp(b.0, b.1)).collect();
        let failures = Failures::new(FailurePolicy::ShiftedInput, rest, guess.states(), guess.steps());
        let step = Step::undecided(guess.inputs());
        Self { sqp, trajectory: guess, k: 0, step, failures, limits: StepLimits::default() }
    }
}

impl SqpController {
    /// What is applied when a sample has no solution; an empty `rest` is zero or the bound closest to it.
    ///
    /// # Errors
    /// If policy or input of rest do not fit the problem.
    pub fn with_failure_policy(mut self, policy: FailurePolicy, rest: &[f64]) -> Result<Self, MpcError> {
        let ocp = self.sqp.ocp();
        policy.check(ocp.states(), ocp.inputs())?;
        let rest = rest_input(rest, &ocp.input_bounds)?;
        self.failures = Failures::new(policy, rest, ocp.states(), self.trajectory.steps());
        Ok(self)
    }
}

impl Controller for SqpController {
    fn feedback(&mut self, x: &[f64]) -> Result<&Step, MpcError> {
        check_length("the measured state", x.len(), self.sqp.ocp().states())?;
        self.sqp.set_start(self.k);
        self.failures.believe(x);
        let limits = std::mem::take(&mut self.limits);
        let (mut seconds, mut effort) = (0.0, SolverEffort::default());
        let status = if let Some(reason) = FallbackReason::of_measurement(x) {
            self.step.residual = None;
            StepStatus::Fallback(reason)
        } else {
            self.sqp.limit_programs(limits)?;
            let mut solution = self.sqp.solve_next(x, &self.trajectory)?;
            seconds = solution.seconds;
            let status = match solution.status {
                SolveStatus::Converged
                | SolveStatus::Infeasible { .. }
                | SolveStatus::IterationLimit
                | SolveStatus::Stalled
                    if !solution.cost.is_finite() =>
                {
                    StepStatus::Fallback(FallbackReason::Cost)
                }
                SolveStatus::Converged => StepStatus::Solved,
                SolveStatus::Infeasible { .. } => StepStatus::Infeasible,
                SolveStatus::IterationLimit | SolveStatus::Stalled => StepStatus::Inaccurate,
                SolveStatus::QpFailed(QpStatus::Limit) if solution.seconds >= limits.time => {
                    StepStatus::Fallback(FallbackReason::TimeLimit)
                }
                SolveStatus::QpFailed(s) => StepStatus::Fallback(FallbackReason::Qp(s)),
                SolveStatus::NotANumber | SolveStatus::IntegratorFailed => {
                    StepStatus::Fallback(FallbackReason::Linearization)
                }
            };
            if !matches!(status, StepStatus::Fallback(_)) {
                std::mem::swap(&mut self.trajectory, &mut solution.trajectory);
            }
            effort = self.sqp.take_effort();
            effort.interior_point_steps += solution.interior_point_steps;
            self.sqp.recycle(solution);
            self.step.residual = (!matches!(status, StepStatus::Fallback(_))).then(|| self.sqp.residual());
            status
        };
        self.step.status = status;
        self.step.source = if matches!(status, StepStatus::Fallback(_)) {
            self.failures.decide(&self.trajectory, &self.sqp.ocp().input_bounds, &mut self.step.u)
        } else {
            self.step.u.copy_from_slice(self.trajectory.u(0));
            self.failures.solved(self.trajectory.steps());
            InputSource::Program
        };
        self.step.timings = Timings { qp: seconds, ..Timings::default() };
        self.step.effort = effort;
        Ok(&self.step)
    }
    fn shift(&mut self) {
        self.failures.shift();
        self.k += 1;
        self.sqp.set_start(self.k);
        self.sqp.shift(&mut self.trajectory);
    }
    fn plan(&self) -> &PlannedTrajectory {
        &self.trajectory
    }
    fn ocp(&self) -> &Ocp {
        self.sqp.ocp()
    }
    fn change(&mut self, change: &mut dyn FnMut(&mut Ocp)) -> Result<(), MpcError> {
        self.sqp.change(change)?;
        self.trajectory.clamp_inputs(&self.sqp.ocp().input_bounds);
        Ok(())
    }
    fn set_start(&mut self, k0: usize) {
        self.k = k0;
    }
    fn limit_next_step(&mut self, limits: StepLimits) {
        self.limits = limits;
    }
    fn set_parameters(&mut self, parameters: &[f64]) -> Result<(), MpcError> {
        self.sqp.set_parameters(parameters)
    }
}
