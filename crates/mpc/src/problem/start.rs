//! The controller of a problem at its start: its method, its first plan, and what stands between it and the measurement.

use super::control_problem::ControlProblem;
use super::method::{Convergence, Feedback, Method};
use super::open_loop::{OTHER_START, Rehearsal};
use super::verdict::floor;
use crate::closed_loop::DelayCompensated;
use crate::controller::{Controller, Rounded, StepStatus, WithPreviousInput};
use crate::dynamics::SymbolicDynamics;
use crate::error::{MpcError, check_flag};
use crate::estimation::OutputFeedback;
use crate::exact_friction::{StickSlipController, StickSlipSettings};
use crate::ocp::{HorizonCost, Ocp};
use crate::rti::{Horizon, Rti, RtiSettings};
use crate::sqp::{Solution, SolveStatus, Sqp, SqpController, SqpSettings};
use crate::trajectory::PlannedTrajectory;

/// Intervals left at which a shrinking horizon is played out instead of solved again.
const MIN_STEPS: usize = 1;
/// Programs with whole steps from which a problem with smoothed friction is solved a second time.
const WHOLE_STEPS: usize = 50;
/// Share of the plan's margin that the loop keeps too: bounds hold at the samples, and a state curves beyond them in between.
const LOOP_SHARE: f64 = 0.2;

/// Share by which a plan from another start has to cost less to be taken.
const OTHER: f64 = 0.01;
/// How many times as much as the guess at rest its roll-out may cost.
const FAR_AWAY: f64 = 1e6;

/// A controller at its start, with what its first plan told.
pub(super) struct Prepared {
    pub(super) controller: Box<dyn Controller>,
    /// The plan, where the method makes one that it tracks.
    pub(super) plan: Option<Solution>,
    /// Stage and terminal cost of the first plan that an input is taken from.
    pub(super) predicted: HorizonCost,
}

/// The controller of a problem at its start, with everything that stands between it and the measurement.
pub(crate) struct Started {
    /// The problem with its method.
    pub(crate) problem: ControlProblem,
    pub(crate) controller: Box<dyn Controller>,
    pub(crate) plan: Option<Solution>,
    pub(crate) predicted: HorizonCost,
    /// Samples that it predicts over.
    pub(crate) delay: usize,
}

impl ControlProblem {
    /// The compiled model, which is made once for a problem that is started.
    pub(super) fn dynamics(&self) -> Result<Box<SymbolicDynamics>, MpcError> {
        if let Some(compiled) = &self.compiled {
            return Ok(compiled.clone());
        }
        let live: Vec<&str> = self.live.iter().map(String::as_str).collect();
        SymbolicDynamics::with_live_parameters(&self.system, &live).map(Box::new)
    }

    pub(super) fn sqp_settings(&self) -> SqpSettings {
        let Convergence { max_iterations, tolerance, defect_tolerance, hessian } = self.method.convergence();
        SqpSettings {
            max_iterations,
            tolerance,
            defect_tolerance,
            hessian,
            smoothing: self.widths(),
            qp: self.qp,
            stop: self.stop.clone(),
            ..SqpSettings::default()
        }
    }

    /// Solves the problem from the guess, with the bounds tightened by the margin; once more where something shows that this plan is
    /// not the best one.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together; how the solution process ends is a status.
    pub fn plan(&self) -> Result<Solution, MpcError> {
        if self.has_free_values() {
            return self.with_free_values()?.plan();
        }
        if let Some(tree) = &self.scenarios {
            return tree.plan(self);
        }
        let ocp = self.ocp.tightened(self.method.margin());
        let mut sqp = Sqp::new(self.dynamics()?, ocp, self.sqp_settings())?;
        let x0 = self.initial_state();
        // The roll-out of an unstable model ends far away: the guess at rest is another start.
        let (rolled, at_rest) = (sqp.guess(&x0, &self.guess)?, self.start());
        let limit = FAR_AWAY * (self.value(&at_rest).abs() + floor(self, self.ocp.steps));
        let cost = self.value(&rolled);
        let far = self.system.is_smooth() && (cost.is_nan() || cost > limit);
        let (first, second) = if far { (at_rest, rolled) } else { (rolled, at_rest) };
        let mut best = sqp.solve(&x0, &first)?;
        if best.status != SolveStatus::Converged && self.system.is_smooth() {
            let other = sqp.solve(&x0, &second)?;
            self.keep_better(&mut best, other);
        }
        self.solve_again(&mut sqp, &mut best)?;
        for start in self.other_starts(second) {
            if let Some(better) = self.better_from(&sqp, &best, &start)? {
                let again = sqp.solve(&x0, &better.trajectory)?;
                self.keep_better(&mut best, better);
                self.keep_better(&mut best, again);
            }
        }
        Ok(best)
    }

    /// The initial state with the previous inputs.
    pub(super) fn initial_state(&self) -> Vec<f64> {
        let mut x = self.x0.clone();
        self.ocp.append_previous(&mut x, &self.first_input());
        x
    }

    /// Real-time iteration along `trajectory`.
    fn rti(
        &self,
        feedback: Feedback,
        ocp: Ocp,
        trajectory: PlannedTrajectory,
        horizon: Horizon,
    ) -> Result<Rti, MpcError> {
        let Feedback { iterations, proximal, guarded, time_limit } = feedback;
        let settings = RtiSettings {
            horizon,
            smoothing: self.widths().last().copied(),
            proximal,
            guarded,
            rest_input: self.rest_input.clone(),
            policy: self.policy.clone(),
            iterations,
            time_limit,
            qp: self.qp,
            ..RtiSettings::default()
        };
        Rti::new(self.dynamics()?, ocp, trajectory, settings)
    }

    /// As [`ControlProblem::rti`], on the receding horizon.
    pub(super) fn receding(&self, feedback: Feedback, trajectory: PlannedTrajectory) -> Result<Rti, MpcError> {
        self.rti(feedback, self.ocp.clone(), trajectory, Horizon::Receding)
    }

    /// The guess, at rest in the initial state.
    pub(super) fn start(&self) -> PlannedTrajectory {
        let mut start = PlannedTrajectory::constant(self.ocp.steps, &self.initial_state(), &self.first_input());
        for (k, u) in self.guess.iter().enumerate() {
            start.u_mut(k).copy_from_slice(u);
        }
        start
    }

    /// The input before the first decision takes effect.
    pub(crate) fn first_input(&self) -> Vec<f64> {
        if !self.u0.is_empty() {
            return self.u0.clone();
        }
        if self.rest_input.is_empty() { self.ocp.inputs_at_rest() } else { self.rest_input.clone() }
    }

    /// Cost of the plan after the first sample's programs along `trajectory`; NaN where they have no solution.
    fn first_predicted_cost(
        &self,
        feedback: Feedback,
        trajectory: &PlannedTrajectory,
    ) -> Result<HorizonCost, MpcError> {
        let mut ocp = self.ocp.clone();
        let mut rti = self.receding(feedback, trajectory.clone())?;
        let planned = !matches!(rti.feedback(&self.initial_state())?.status, StepStatus::Fallback(_));
        Ok(if planned { ocp.costs(0, rti.trajectory()) } else { HorizonCost::NONE })
    }

    /// The controller at its start, with delay compensation and estimator. Where the method is
    /// [`Method::Automatic`], it is chosen here.
    pub(crate) fn started(&self) -> Result<Started, MpcError> {
        let own = Self { compiled: Some(self.dynamics()?), ..self.clone() };
        let (problem, Prepared { mut controller, mut plan, predicted }) = match (&own.scenarios, own.method) {
            (Some(tree), _) => tree.started(&own)?,
            (None, Method::Automatic { convergence }) => own.choose_method(convergence)?,
            (None, _) => own.prepared().map(|prepared| (own, prepared))?,
        };
        let first = self.first_input();
        if self.has_finite_inputs() {
            controller = Box::new(Rounded::new(controller)?);
        }
        if !self.ocp.previous_inputs.is_empty() {
            controller = Box::new(WithPreviousInput::new(controller, &first)?);
            if let Some(plan) = &mut plan {
                plan.trajectory = plan.trajectory.first_states(self.ocp.model_states());
            }
        }
        let delay = self.known_delay()?;
        let controller: Box<dyn Controller> = if delay > 0 {
            Box::new(DelayCompensated::new(controller, problem.dynamics()?, delay, &first)?)
        } else {
            controller
        };
        let controller: Box<dyn Controller> = match &self.estimation {
            Some(e) => {
                let (estimator, hand_over) = (e.estimator()?, e.hands_over());
                Box::new(OutputFeedback::new(controller, estimator, hand_over, self.conditions.delay, &first)?)
            }
            None => controller,
        };
        Ok(Started { problem, controller, plan, predicted, delay })
    }

    /// Samples between a measurement and its input that the controller predicts over.
    fn known_delay(&self) -> Result<usize, MpcError> {
        let known = self.conditions.delay + self.delay_of_inputs()?;
        Ok(if self.conditions.compensate_delay { known } else { 0 })
    }

    /// Samples between a measurement and its input that the controller predicts over; 0 where the delays of the inputs differ, which
    /// no controller is made for.
    pub fn compensated_delay(&self) -> usize {
        self.known_delay().unwrap_or(0)
    }

    /// By how much the inputs of the plant act later than measured for, in samples, the largest of them; and how many samples of it the
    /// controller predicts over.
    pub(super) fn delay_of_plant(&self) -> (f64, usize) {
        let of_inputs = self.plant.delay_values().into_iter().flatten().fold(0.0, f64::max);
        (self.conditions.delay as f64 + of_inputs / self.ocp.dt, self.compensated_delay())
    }

    /// Names of what is measured: the outputs of the estimator, else the states.
    pub fn measured(&self) -> Vec<String> {
        self.estimation.as_ref().map_or_else(|| self.system.state_names(), |e| e.names.clone())
    }

    /// The controller of the problem's method at its start.
    pub(super) fn prepared(&self) -> Result<Prepared, MpcError> {
        match self.method {
            Method::Automatic { convergence } => self.choose_method(convergence).map(|(_, prepared)| prepared),
            Method::Plan { margin, feedback, .. } => self.tracker(margin, feedback),
            Method::Rti { initial_iterations, feedback } => {
                let mut rti = self.receding(feedback, self.start())?;
                for _ in 1..initial_iterations {
                    check_flag(&self.stop)?;
                    rti.feedback(&self.initial_state())?;
                }
                let predicted = self.first_predicted_cost(feedback, rti.trajectory())?;
                Ok(Prepared { controller: Box::new(rti), plan: None, predicted })
            }
            Method::Sqp { first, .. } => {
                let mut sqp = self.solver()?;
                let solution = self.first_solution(&mut sqp, first)?;
                let solution = self.best_first_solution(&mut sqp, solution)?;
                self.converged(sqp, solution)
            }
            Method::StickSlip { iterations } => self.on_exact_flow(self.stick_slip(iterations)?),
        }
    }

    /// Plans, and tracks the plan.
    pub(super) fn tracker(&self, margin: f64, feedback: Feedback) -> Result<Prepared, MpcError> {
        let plan = self.plan()?;
        let ocp = self.ocp.tightened(LOOP_SHARE * margin);
        let horizon = Horizon::Shrinking { min_steps: MIN_STEPS };
        let tracker = self.rti(feedback, ocp, plan.trajectory.clone(), horizon)?;
        let predicted = self.ocp.clone().costs(0, &plan.trajectory);
        Ok(Prepared { controller: Box::new(tracker), plan: Some(plan), predicted })
    }

    /// Converged solutions at every sample, from the first one.
    pub(super) fn converged(&self, sqp: Sqp, solution: Solution) -> Result<Prepared, MpcError> {
        let predicted = self.ocp.clone().costs(0, &solution.trajectory);
        let controller =
            SqpController::new(sqp, solution.trajectory).with_failure_policy(self.policy.clone(), &self.rest_input)?;
        Ok(Prepared { controller: Box::new(controller), plan: None, predicted })
    }

    /// The controller on exact friction, with the guess.
    pub(super) fn stick_slip(&self, iterations: usize) -> Result<StickSlipController, MpcError> {
        let settings = StickSlipSettings {
            iterations,
            smoothing: self.widths(),
            live_parameters: self.live.clone(),
            failure: self.policy.clone(),
            rest_input: self.rest_input.clone(),
            qp: self.qp,
            stop: self.stop.clone(),
            ..StickSlipSettings::default()
        };
        StickSlipController::new(&self.system, self.ocp.clone(), self.start(), settings)
    }

    /// The controller on exact friction, with its first plan.
    pub(super) fn on_exact_flow(&self, mut controller: StickSlipController) -> Result<Prepared, MpcError> {
        let predicted = self.ocp.clone().costs(0, controller.plan_from(&self.initial_state())?);
        Ok(Prepared { controller: Box::new(controller), plan: None, predicted })
    }

    /// The solver of the problem.
    pub(super) fn solver(&self) -> Result<Sqp, MpcError> {
        Sqp::new(self.dynamics()?, self.ocp.clone(), self.sqp_settings())
    }

    /// The first converged solution. With smoothed friction, whole steps often find a better one through states that a merit function
    /// forbids.
    pub(super) fn first_solution(&self, sqp: &mut Sqp, whole_steps: Feedback) -> Result<Solution, MpcError> {
        let mut best = sqp.solve_first(&self.initial_state(), &self.start())?;
        if !self.system.is_smooth() {
            let mut rti = self.receding(whole_steps, self.start())?;
            for _ in 0..WHOLE_STEPS {
                check_flag(&self.stop)?;
                rti.feedback(&self.initial_state())?;
            }
            self.keep_better(&mut best, sqp.solve(&self.initial_state(), rti.trajectory())?);
        }
        self.solve_again(sqp, &mut best)?;
        Ok(best)
    }

    /// The better one of a first solution and those from other starts.
    pub(super) fn best_first_solution(&self, sqp: &mut Sqp, mut best: Solution) -> Result<Solution, MpcError> {
        let x0 = self.initial_state();
        let rolled = sqp.guess(&x0, &self.guess)?;
        for start in self.other_starts(rolled) {
            if let Some(better) = self.better_from(sqp, &best, &start)? {
                // The controller goes on from what its solver has solved last.
                let again = sqp.solve_first(&x0, &better.trajectory)?;
                self.keep_better(&mut best, better);
                self.keep_better(&mut best, again);
            }
        }
        Ok(best)
    }

    /// Starts beside that of the first solution: `second`, and in runs that are long enough for another plan to hardly add to their time, one
    /// away from the guess.
    fn other_starts(&self, second: PlannedTrajectory) -> Vec<PlannedTrajectory> {
        let elsewhere = self.tries_elsewhere().then(|| self.elsewhere().1);
        std::iter::once(second).chain(elsewhere).collect()
    }

    /// Whether plans of this problem start away from the guess, too.
    pub(super) fn tries_elsewhere(&self) -> bool {
        self.has_run && self.samples >= OTHER_START && self.has_other_starts()
    }

    /// Free values have a search of their own, after which their guess is a plan, and smoothed friction has other starts.
    fn has_other_starts(&self) -> bool {
        self.system.is_smooth() && self.found.is_none() && self.ocp.constant_inputs.is_empty()
    }

    /// A plan from another start that costs less than `best` by more than 1 %.
    fn better_from(&self, sqp: &Sqp, best: &Solution, start: &PlannedTrajectory) -> Result<Option<Solution>, MpcError> {
        if !self.has_other_starts() || !start.is_finite() {
            return Ok(None);
        }
        let mut solver = Sqp::new(self.dynamics()?, sqp.ocp().clone(), self.sqp_settings())?;
        let other = solver.solve_first(&self.initial_state(), start)?;
        let [before, now] = [best, &other].map(|s| self.value(&s.trajectory));
        // What did not converge may still be close to a plan that is worth more than another that did, as one that misses targets.
        let is_plan = best.status == SolveStatus::Converged || best.defect <= self.sqp_settings().defect_tolerance;
        let less = before - now > OTHER * before.abs().max(now.abs());
        let taken = other.status == SolveStatus::Converged && (less || !is_plan);
        Ok(taken.then_some(other))
    }

    /// Solves from other starts where the plan is not the best one: from a simple input that costs less, and from waves where it
    /// stays at the guess.
    fn solve_again(&self, sqp: &mut Sqp, best: &mut Solution) -> Result<(), MpcError> {
        let plan = &best.trajectory;
        let stays = self.stays((0..plan.steps()).map(|k| plan.u(k)));
        let held = Rehearsal::smoothed(self)?.best_held(self).filter(|held| held.cost < self.value(plan));
        let starts = [held.map(|held| held.trajectory), stays.then(|| self.waves())];
        for start in starts.into_iter().flatten() {
            let other = sqp.solve(&self.initial_state(), &start)?;
            self.keep_better(best, other);
        }
        Ok(())
    }

    /// Cost and penalties of a plan.
    pub(super) fn value(&self, plan: &PlannedTrajectory) -> f64 {
        let mut ocp = self.ocp.clone();
        ocp.cost(0, plan) + ocp.penalty(0, plan, self.qp.hard_weight)
    }

    fn keep_better(&self, best: &mut Solution, other: Solution) {
        let converged = |s: &Solution| s.status == SolveStatus::Converged;
        if converged(&other) && (!converged(best) || self.value(&other.trajectory) < self.value(&best.trajectory)) {
            *best = other;
        }
    }

    /// Samples, rounded, by which the inputs of the controller's model act later than they are commanded.
    ///
    /// # Errors
    /// If they differ from input to input: the controller predicts over one delay.
    pub(super) fn delay_of_inputs(&self) -> Result<usize, MpcError> {
        let delays = self.system.delay_values();
        let mut samples = delays.iter().map(|d| (d.unwrap_or(0.0) / self.ocp.dt).round() as usize);
        let first = samples.next().unwrap_or(0);
        match samples.position(|other| other != first) {
            None => Ok(first),
            Some(other) => Err(MpcError::Value {
                what: format!("the delay of the input `{}`", self.system.input_names()[other + 1]),
                value: delays[other + 1].unwrap_or(0.0),
                remedy: "the controller predicts over one delay of all inputs; give them the same in whole samples in the \
                         model, and those of the plant in a model of its own: plant = \"other.toml\"",
            }),
        }
    }
}
