//! A control problem run from start to end, and what is to be said about it.

use super::conditions::RunConditions;
use super::control_problem::ControlProblem;
use super::estimation::Estimation;
use super::method::{Convergence, Feedback, Method};
use super::notes::notes;
use super::report::{ClosedLoopReport, KeptRange, PlanReport};
use crate::closed_loop::{ClosedLoop, DelayCompensated, LoopSettings, MeasurementFunction, Plant, run_closed_loop};
use crate::controller::{Controller, StepStatus};
use crate::dynamics::SymbolicDynamics;
use crate::error::{MpcError, check_flag};
use crate::estimation::Estimator;
use crate::exact_friction::{StickSlipController, StickSlipSettings};
use crate::ocp::Ocp;
use crate::rti::{Horizon, Rti, RtiSettings};
use crate::sqp::{Solution, SolveStatus, Sqp, SqpController, SqpSettings};
use crate::trajectory::Trajectory;
use bracketry_system::InputRange;
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// Intervals left at which a shrinking horizon is played out instead of solved again.
const MIN_STEPS: usize = 1;
/// Programs with whole steps from which a problem with smoothed friction is solved a second time.
const WHOLE_STEPS: usize = 50;
/// Share of the plan's margin that the loop keeps too: bounds hold at the samples, and a state curves beyond them in between.
const LOOP_SHARE: f64 = 0.2;

/// A run with its figures.
#[derive(Clone, Debug)]
pub struct ControlRun {
    /// The figures.
    pub report: ClosedLoopReport,
    /// Sampled states and inputs.
    pub closed_loop: ClosedLoop,
    /// The plan, where one was made.
    pub plan: Option<Solution>,
}

/// A controller at its start, with the plan where the method makes one and the cost that it predicts.
type Prepared = (Box<dyn Controller>, Option<Solution>, f64);

impl ControlProblem {
    fn dynamics(&self) -> Result<Box<SymbolicDynamics>, MpcError> {
        let live: Vec<&str> = self.live.iter().map(String::as_str).collect();
        SymbolicDynamics::with_live_parameters(&self.system, &live).map(Box::new)
    }

    fn sqp_settings(&self) -> SqpSettings {
        let Convergence { max_iterations, tolerance, defect_tolerance, hessian } = self.method.convergence();
        SqpSettings {
            max_iterations,
            tolerance,
            defect_tolerance,
            hessian,
            smoothing: self.smoothing.clone(),
            qp: self.qp,
            stop: self.stop.clone(),
            ..SqpSettings::default()
        }
    }

    /// Solves the problem once, from the guess, with the bounds tightened by the margin.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together; how the solution process ends is a status.
    pub fn plan(&self) -> Result<Solution, MpcError> {
        let ocp = self.ocp.tightened(self.method.margin());
        let mut sqp = Sqp::new(self.dynamics()?, ocp, self.sqp_settings())?;
        let guess = sqp.guess(&self.x0, &self.guess)?;
        sqp.solve(&self.x0, &guess)
    }

    /// Real-time iteration along `trajectory`.
    fn rti(&self, feedback: Feedback, ocp: Ocp, trajectory: Trajectory, horizon: Horizon) -> Result<Rti, MpcError> {
        let Feedback { iterations, proximal, guarded, time_limit } = feedback;
        let settings = RtiSettings {
            horizon,
            smoothing: self.smoothing.last().copied(),
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
    fn receding(&self, feedback: Feedback, trajectory: Trajectory) -> Result<Rti, MpcError> {
        self.rti(feedback, self.ocp.clone(), trajectory, Horizon::Receding)
    }

    /// The guess, at rest in the initial state.
    fn start(&self) -> Trajectory {
        let mut start = Trajectory::constant(self.ocp.steps, &self.x0, &self.first_input());
        for (k, u) in self.guess.iter().enumerate() {
            start.u_mut(k).copy_from_slice(u);
        }
        start
    }

    /// The input before the first decision takes effect.
    fn first_input(&self) -> Vec<f64> {
        let rest = self.ocp.input_bounds.iter().map(|b| 0f64.clamp(b.0, b.1));
        if self.rest_input.is_empty() { rest.collect() } else { self.rest_input.clone() }
    }

    /// Cost of the plan after the first sample's programs along `trajectory`; NaN where they have no solution.
    fn first_predicted_cost(&self, feedback: Feedback, trajectory: &Trajectory) -> Result<f64, MpcError> {
        let mut ocp = self.ocp.clone();
        let mut rti = self.receding(feedback, trajectory.clone())?;
        let planned = !matches!(rti.feedback(&self.x0)?.status, StepStatus::Fallback(_));
        Ok(if planned { ocp.cost(0, rti.trajectory()) } else { f64::NAN })
    }

    /// The controller at its start.
    fn controller(&self) -> Result<Prepared, MpcError> {
        match self.method {
            Method::Plan { margin, feedback, .. } => {
                let plan = self.plan()?;
                let ocp = self.ocp.tightened(LOOP_SHARE * margin);
                let horizon = Horizon::Shrinking { min_steps: MIN_STEPS };
                let tracker = self.rti(feedback, ocp, plan.trajectory.clone(), horizon)?;
                let cost = plan.cost;
                Ok((Box::new(tracker), Some(plan), cost))
            }
            Method::Rti { initial_iterations, feedback } => {
                let mut rti = self.receding(feedback, self.start())?;
                for _ in 1..initial_iterations {
                    check_flag(&self.stop)?;
                    rti.feedback(&self.x0)?;
                }
                let cost = self.first_predicted_cost(feedback, rti.trajectory())?;
                Ok((Box::new(rti), None, cost))
            }
            Method::Sqp { first, .. } => {
                let mut sqp = Sqp::new(self.dynamics()?, self.ocp.clone(), self.sqp_settings())?;
                let solution = self.first_solution(&mut sqp, first)?;
                let controller = SqpController::new(sqp, solution.trajectory)
                    .with_failure_policy(self.policy.clone(), &self.rest_input)?;
                Ok((Box::new(controller), None, solution.cost))
            }
            Method::StickSlip { iterations } => {
                let settings = StickSlipSettings {
                    iterations,
                    smoothing: self.smoothing.clone(),
                    live_parameters: self.live.clone(),
                    failure: self.policy.clone(),
                    rest_input: self.rest_input.clone(),
                    qp: self.qp,
                    stop: self.stop.clone(),
                    ..StickSlipSettings::default()
                };
                let mut controller = StickSlipController::new(&self.system, self.ocp.clone(), self.start(), settings)?;
                let cost = self.ocp.clone().cost(0, controller.plan_from(&self.x0)?);
                Ok((Box::new(controller), None, cost))
            }
        }
    }

    /// The first converged solution. With smoothed friction, whole steps often find a better one through states that a merit
    /// function forbids.
    fn first_solution(&self, sqp: &mut Sqp, whole_steps: Feedback) -> Result<Solution, MpcError> {
        let guarded = sqp.solve(&self.x0, &self.start())?;
        if self.system.is_smooth() {
            return Ok(guarded);
        }
        let mut rti = self.receding(whole_steps, self.start())?;
        for _ in 0..WHOLE_STEPS {
            check_flag(&self.stop)?;
            rti.feedback(&self.x0)?;
        }
        let whole = sqp.solve(&self.x0, rti.trajectory())?;
        let better = guarded.status != SolveStatus::Converged || whole.cost < guarded.cost;
        Ok(if whole.status == SolveStatus::Converged && better { whole } else { guarded })
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

    /// Runs the closed loop on a plant.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together or the plant stops.
    pub fn run(&self, plant: &mut dyn Plant) -> Result<ControlRun, MpcError> {
        self.run_disturbed(plant, |_, _| {})
    }

    /// As [`ControlProblem::run`], with the measured state of every sample changed by `disturb`.
    ///
    /// # Errors
    /// As [`ControlProblem::run`].
    pub fn run_disturbed(
        &self,
        plant: &mut dyn Plant,
        disturb: impl FnMut(usize, &mut [f64]),
    ) -> Result<ControlRun, MpcError> {
        let (controller, plan, open_loop_cost) = self.controller()?;
        let first = self.first_input();
        let delay = self.conditions.delay;
        let known = delay + self.delay_of_inputs()?;
        let mut controller: Box<dyn Controller> = if known > 0 && self.conditions.compensate_delay {
            Box::new(DelayCompensated::new(controller, self.dynamics()?, known, &first)?)
        } else {
            controller
        };
        let mut disturb = disturb;
        let mut noise = Noise::new(&self.conditions);
        let mut estimator = self.estimation.as_ref().map(Estimation::estimator).transpose()?;
        let mut outputs = self.estimation.as_ref().map(|e| e.outputs(&self.plant)).transpose()?;
        let settings = LoopSettings {
            estimator: estimator.as_mut().map(|e| e.as_mut() as &mut dyn Estimator),
            hand_over: self.estimation.as_ref().is_some_and(Estimation::hands_over),
            measurement: outputs
                .as_mut()
                .map(|h| Box::new(|t: f64, x: &[f64]| h.values(x, &[], t, &[]).to_vec()) as MeasurementFunction<'_>),
            noise: Some(Box::new(move |k, y| {
                noise.add(y);
                disturb(k, y);
            })),
            delay,
            initial_input: first,
            faults: Some(Box::new(|k| self.conditions.faults_at(k))),
            stop: self.stop.clone(),
        };
        let run = run_closed_loop(controller.as_mut(), plant, &self.x0, self.samples, settings)?;
        let end = run.x.last().unwrap_or(&self.x0);
        let names = self.system.state_names();
        let planned = plan.as_ref().is_none_or(|p| p.status == SolveStatus::Converged);
        // The linear weight of a target is the inverse of its tolerance.
        let met = self.ocp.targets.iter().all(|t| (end[t.state] - t.value).abs() * t.linear <= 1.0);
        let finite = end.iter().chain([&run.cost, &open_loop_cost]).all(|v| v.is_finite());
        let succeeded = finite
            && run.counts.infeasible + run.counts.fallback == 0
            && if self.ocp.targets.is_empty() { planned } else { met };
        let constraints = self.ocp.clone().largest_constraint_violation(&run.x, &run.u);
        let bounds = self.ocp.largest_violation(&run.x[1..], &run.u);
        // `f64::max` would drop a NaN.
        let violation = if constraints > bounds || constraints.is_nan() { constraints } else { bounds };
        let report = ClosedLoopReport {
            succeeded,
            notes: notes(self, &run, open_loop_cost),
            closed_loop_cost: run.cost,
            open_loop_cost,
            x_final: names.iter().cloned().zip(end.iter().copied()).collect(),
            miss: self.ocp.targets.iter().map(|t| (names[t.state].clone(), end[t.state] - t.value)).collect(),
            steps: run.steps.len(),
            status: run.counts,
            solve_ms: run.times,
            period_ms: 1e3 * self.ocp.dt,
            constraint_violation_max: violation,
            input_ranges: self.kept_ranges(),
            plan: plan.as_ref().map(|p| PlanReport {
                status: p.status.to_string(),
                programs: p.iterations.len(),
                defect: p.defect,
                seconds: p.seconds,
            }),
        };
        Ok(ControlRun { report, closed_loop: run, plan })
    }

    /// The bounds of the inputs that have a range in the model.
    fn kept_ranges(&self) -> Vec<KeptRange> {
        let kept = |range: &InputRange| {
            let j = self.system.inputs.iter().position(|u| *u == range.input)?;
            let (min, max) = self.ocp.input_bounds[j];
            let finite = |end: f64| end.is_finite().then_some(end);
            let input = self.system.symbol_name(range.input).to_owned();
            Some(KeptRange { input, min: finite(min), max: finite(max) })
        };
        self.system.input_ranges.iter().filter_map(kept).collect()
    }
}

/// Normally distributed noise on what is measured.
struct Noise {
    deviations: Vec<f64>,
    random: StdRng,
}

impl Noise {
    fn new(conditions: &RunConditions) -> Self {
        Self { deviations: conditions.noise.clone(), random: StdRng::seed_from_u64(conditions.seed) }
    }

    fn add(&mut self, y: &mut [f64]) {
        for (y, deviation) in y.iter_mut().zip(&self.deviations).filter(|(_, d)| **d > 0.0) {
            let e: f64 = StandardNormal.sample(&mut self.random);
            *y += deviation * e;
        }
    }
}
