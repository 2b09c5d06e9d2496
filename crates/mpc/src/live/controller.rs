//! The controller of a problem with its estimator, delay compensation and failure policy, one sample at a time.

use super::log::LoopLog;
use crate::controller::{Controller, Step, StepLimits};
use crate::error::{MpcError, check_length, check_value};
use crate::estimation::Estimate;
use crate::ocp::Bounded;
use crate::problem::{ControlProblem, Method, MethodReason, Schedule, Scheduled};
use crate::trajectory::PlannedTrajectory;

/// Grid points by which the known references and parameters are continued at a time.
const CONTINUED: usize = 1000;

/// One sample's input, and which sample it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveStep {
    /// Number of the sample, from 0.
    pub sample: usize,
    /// Samples before it that got no measurement: the input before them is taken to have been held.
    pub missed: usize,
    /// Input, status, source, and times.
    pub step: Step,
    /// The measured or estimated states less what the plan of the sample before predicted: what model and plant differ by. Empty for the
    /// first sample, after missed ones, and where a delay is compensated.
    pub innovation: Vec<f64>,
}

/// The controller of a problem, stepped by its user: the same object that
/// [`control`](crate::control) runs, with estimator, delay compensation, and failure policy.
///
/// A sample is [`feedback`](LiveController::feedback) from the measurement to the input, and
/// [`prepare`](LiveController::prepare) while the input acts. [`step`](LiveController::step) is both for callers whose
/// time does not matter.
///
/// The measurement `y` has one entry per name of [`measured`](LiveController::measured): the states, or the outputs of
/// the estimator. An entry is NaN where nothing was measured. The input `u` is to be held for one
/// [`period`](LiveController::period).
///
/// ```
/// use bracketry_mpc::ControlProblem;
/// use bracketry_system::System;
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let model = r#"
///     states = ["x", "v"]
///     inputs = ["a"]
///     dynamics = { x = "v", v = "a" }
/// "#;
/// let problem = r#"
///     model = "mass.toml"
///     horizon = { steps = 30, dt = 0.1 }
///     cost = { stage = "x^2 + 0.1*v^2 + 0.01*a^2" }
///     constraints = { a = { min = -1, max = 1 } }
///     run = { x0 = { x = 1 } }
/// "#;
/// let problem = ControlProblem::parse("problem.toml", problem, |f| System::parse(f, model).map_err(Box::new))?;
/// let mut controller = problem.controller()?;
/// let (mut x, mut v) = (1.0, 0.0);
/// for _ in 0..100 {
///     let a = controller.step(&[x, v])?.step.u[0];
///     (x, v) = (x + 0.1 * v + 0.005 * a, v + 0.1 * a); // the plant
/// }
/// assert!(x.abs() < 1e-3);
/// # Ok(())
/// # }
/// ```
///
/// With real-time iteration and sequential quadratic programs, neither feedback nor preparation allocates memory of its own; Clarabel's
/// update does. Exact friction and moving-horizon estimation allocate at every sample.
pub struct LiveController {
    pub(super) problem: ControlProblem,
    pub(super) controller: Box<dyn Controller>,
    delay: usize,
    answer: LiveStep,
    /// The sample that a measurement is expected for.
    pub(super) sample: usize,
    /// Whether the horizon still stands at the sample before.
    answered: bool,
    /// Time of sample 0 on the caller's clock, s.
    origin: Option<f64>,
    prediction: PlannedTrajectory,
    nothing: Vec<f64>,
    log: Option<LoopLog>,
    /// The method as the problem gives it.
    given: (Method, MethodReason),
    /// Whether the first measured state is to be the initial one.
    awaits_start: bool,
}

impl ControlProblem {
    /// The controller of this problem, to be stepped on any plant. A problem without `[run]` starts from the first measured state, for
    /// which its method is chosen and its first plan made once more. Chooses the method where the problem leaves it open, and makes
    /// the first plan where the method has one, from `x0` of the run. What the run says of noise, faults, and the plant is left out.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together.
    pub fn controller(&self) -> Result<LiveController, MpcError> {
        LiveController::new(self)
    }
}

impl LiveController {
    fn new(problem: &ControlProblem) -> Result<Self, MpcError> {
        let problem = problem.with_free_values()?.into_owned();
        let given = (problem.method, problem.method_reason.clone());
        let awaits_start = !problem.has_run && problem.estimation.is_none();
        let started = problem.started()?;
        // What is handed out may be changed and started anew: it is compiled again.
        let problem = ControlProblem { compiled: None, ..started.problem };
        let inputs = problem.ocp.inputs();
        let nothing = vec![f64::NAN; problem.measured().len()];
        Ok(Self {
            prediction: started.controller.plan().clone(),
            controller: started.controller,
            delay: started.delay,
            answer: LiveStep { sample: 0, missed: 0, step: Step::undecided(inputs), innovation: Vec::new() },
            sample: 0,
            answered: false,
            origin: None,
            nothing,
            log: None,
            given,
            awaits_start,
            problem,
        })
    }

    /// The input for the measurement `y` of the next sample: [`LiveController::prepare`] where it has not been called, then
    /// [`LiveController::feedback`].
    ///
    /// # Errors
    /// If `y` has the wrong length. Measurements that are not finite and trouble while solving are statuses.
    pub fn step(&mut self, y: &[f64]) -> Result<&LiveStep, MpcError> {
        check_length("the measurement", y.len(), self.nothing.len())?;
        self.prepare()?;
        self.feedback(y)
    }

    /// As [`LiveController::step`], for a measurement taken at the time `t` (s) on the caller's clock, whose first time is that of
    /// the next sample. Times are rounded to samples. Samples that have passed without a measurement are compensated.
    ///
    /// # Errors
    /// If `y` has the wrong length; [`MpcError::Time`] if `t` is not finite, belongs to a sample that has been answered, or lies
    /// more than a horizon ahead. The controller is then as it was.
    pub fn step_at(&mut self, y: &[f64], t: f64) -> Result<&LiveStep, MpcError> {
        check_length("the measurement", y.len(), self.nothing.len())?;
        let next = self.next() as f64;
        let origin = self.origin.unwrap_or(t - next * self.period());
        let passed = ((t - origin) / self.period()).round() - next;
        let refused = if !t.is_finite() {
            Some("give seconds")
        } else if passed < 0.0 {
            Some("its sample is already answered: give measurements in order of time, one per period")
        } else if passed > self.problem.ocp.samples_of_horizon() as f64 {
            Some("it is more than one horizon after the last: reset the controller")
        } else {
            None
        };
        if let Some(reason) = refused {
            return Err(MpcError::Time { time: t, reason });
        }
        self.origin = Some(origin);
        for _ in 0..passed as usize {
            self.skip()?;
        }
        self.prepare()?;
        self.answer.missed = passed as usize;
        self.answer(y)
    }

    /// Everything that does not need the measurement of the next sample: moves the horizon, linearizes, and fills in the program.
    ///
    /// # Errors
    /// If a setting of the programs is out of its range.
    pub fn prepare(&mut self) -> Result<(), MpcError> {
        self.settle()?;
        self.controller.prepare()
    }

    /// Moves on from an answered sample.
    fn settle(&mut self) -> Result<(), MpcError> {
        if !self.answered {
            return Ok(());
        }
        self.prediction.copy_from(self.controller.plan());
        self.controller.shift();
        self.sample += 1;
        self.answered = false;
        self.continue_schedule()
    }

    /// The input for the measurement `y`, as fast as possible after a [`LiveController::prepare`].
    ///
    /// # Errors
    /// If `y` has the wrong length.
    pub fn feedback(&mut self, y: &[f64]) -> Result<&LiveStep, MpcError> {
        check_length("the measurement", y.len(), self.nothing.len())?;
        self.settle()?;
        self.answer.missed = 0;
        self.answer(y)
    }

    /// The input of a sample whose measurement has not come in time: that of the failure policy.
    ///
    /// # Errors
    /// As [`LiveController::step`].
    pub fn lost(&mut self) -> Result<&LiveStep, MpcError> {
        let nothing = std::mem::take(&mut self.nothing);
        let answered = self.prepare().and_then(|()| {
            self.answer.missed = 0;
            self.answer(&nothing).map(|_| ())
        });
        self.nothing = nothing;
        answered.map(|()| &self.answer)
    }

    /// Starts from the measured state, where the problem has no other.
    fn start_from(&mut self, x0: &[f64]) -> Result<(), MpcError> {
        let mut problem = self.problem.clone();
        (problem.method, problem.method_reason) = self.given.clone();
        problem.x0.copy_from_slice(x0);
        let (sample, missed, origin, log) = (self.sample, self.answer.missed, self.origin, self.log.take());
        *self = Self::new(&problem)?;
        (self.sample, self.answer.missed, self.origin, self.log) = (sample, missed, origin, log);
        self.awaits_start = false;
        self.controller.set_start(sample);
        self.continue_schedule()
    }

    fn answer(&mut self, y: &[f64]) -> Result<&LiveStep, MpcError> {
        if self.awaits_start && y.iter().all(|v| v.is_finite()) {
            self.start_from(y)?;
        }
        self.answer.step.copy_from(self.controller.feedback(y)?);
        self.note_innovation(y);
        self.answer.sample = self.sample;
        self.answered = true;
        if let Some(log) = &mut self.log {
            log.add(self.sample, y, &self.answer.step);
        }
        Ok(&self.answer)
    }

    /// Compares the states of an answered sample with the plan before.
    fn note_innovation(&mut self, y: &[f64]) {
        let LiveStep { innovation, missed, .. } = &mut self.answer;
        innovation.clear();
        if self.sample == 0 || *missed > 0 || self.delay > 0 || self.prediction.steps() == 0 {
            return;
        }
        let x = self.controller.estimate().map_or(y, |e| &e.x);
        let states = self.problem.ocp.model_states();
        innovation.extend(x.iter().zip(self.prediction.x(1)).take(states).map(|(x, predicted)| x - predicted));
    }

    /// A sample without a measurement and without an answer, over which the last input was held.
    fn skip(&mut self) -> Result<(), MpcError> {
        self.settle()?;
        self.controller.skip()?;
        if let Some(log) = &mut self.log {
            log.add(self.sample, &self.nothing, &self.answer.step);
        }
        self.sample += 1;
        self.continue_schedule()
    }

    /// The sample that the next measurement belongs to.
    pub(super) fn next(&self) -> usize {
        self.sample + usize::from(self.answered)
    }

    /// Rows of references and parameters for a horizon that goes beyond those there are.
    fn continue_schedule(&mut self) -> Result<(), MpcError> {
        let ocp = self.controller.ocp();
        let rows = ocp.references.len().max(ocp.parameters.len());
        let last = self.sample + self.delay + ocp.samples_of_horizon();
        if !self.problem.schedule.varies() || last < ocp.first_row + rows {
            return Ok(());
        }
        let schedule = &self.problem.schedule;
        let (first, points) = self.rows(schedule);
        self.controller.change(&mut |ocp| schedule.write(ocp, first, points))
    }

    /// First row and number of rows after it that a schedule needs from the sample on, far enough for some horizons.
    pub(super) fn rows(&self, schedule: &Schedule) -> (usize, usize) {
        let points = if schedule.varies() { self.delay + self.problem.ocp.samples_of_horizon() + CONTINUED } else { 0 };
        (self.sample, points)
    }

    /// Starts again from `x0` of the problem, or, where it has no `[run]`, from the next measured state, at sample 0: plans, estimates, and counted failures are forgotten. Changes of
    /// references, parameters, bounds, and targets stay.
    ///
    /// # Errors
    /// As [`ControlProblem::controller`].
    pub fn reset(&mut self) -> Result<(), MpcError> {
        self.start_again(self.problem.clone())
    }

    /// As [`LiveController::reset`], from another state, this once.
    ///
    /// # Errors
    /// If the length of `x0` is wrong, and as [`ControlProblem::controller`].
    pub fn reset_to(&mut self, x0: &[f64]) -> Result<(), MpcError> {
        check_length("the initial state", x0.len(), self.problem.x0.len())?;
        for &value in x0 {
            check_value(value.is_finite(), "the initial state", value, "give finite numbers")?;
        }
        let mut problem = self.problem.clone();
        problem.x0.copy_from_slice(x0);
        if self.awaits_start {
            (problem.method, problem.method_reason) = self.given.clone();
        }
        let home = std::mem::take(&mut self.problem.x0);
        let started = self.start_again(problem);
        self.problem.x0 = home;
        self.awaits_start &= started.is_err();
        started
    }

    fn start_again(&mut self, mut problem: ControlProblem) -> Result<(), MpcError> {
        let rows = problem.samples + problem.ocp.steps;
        problem.schedule.write(&mut problem.ocp, 0, rows);
        let mut started = Self::new(&problem)?;
        started.log = self.log.take().map(LoopLog::cleared);
        // The method as the problem gives it is known to the first of them alone.
        started.given = self.given.clone();
        *self = started;
        Ok(())
    }

    /// Limits the next sample alone.
    pub fn limit_next_step(&mut self, limits: StepLimits) {
        self.controller.limit_next_step(limits);
    }

    /// Keeps the last `samples` samples, from now on.
    pub fn keep_log(&mut self, samples: usize) {
        let first = self.problem.first_input();
        self.log = Some(LoopLog::new(&self.problem, samples, &first));
    }

    /// The samples kept since [`LiveController::keep_log`].
    pub fn log(&self) -> Option<&LoopLog> {
        self.log.as_ref()
    }

    /// The last answer.
    pub fn last(&self) -> &LiveStep {
        &self.answer
    }

    /// States and inputs that the last answer's program predicts, on the grid of the horizon. They start at the time of the
    /// measurement, or where the controller compensates a delay, when the input begins to act.
    pub fn prediction(&self) -> &PlannedTrajectory {
        if self.answered { self.controller.plan() } else { &self.prediction }
    }

    /// Cost of [`LiveController::prediction`] over the horizon, without penalties.
    pub fn predicted_cost(&self) -> f64 {
        let mut ocp = self.controller.ocp().clone();
        ocp.round_norms(0.0);
        ocp.cost(self.answer.sample + self.delay, self.prediction())
    }

    /// Slacks of the soft bounds and constraints along [`LiveController::prediction`]: the largest violation of each, by name. With
    /// a scenario tree, a name may occur once per branch.
    pub fn slacks(&self) -> Vec<(String, f64)> {
        let mut ocp = self.controller.ocp().clone();
        let found = ocp.soft_violations(self.answer.sample + self.delay, self.prediction());
        let (states, path) = (self.states(), &ocp.path_constraints);
        let name = |of: &Bounded| match *of {
            Bounded::State(i) => states.get(i).cloned(),
            Bounded::Constraint(c) => {
                path.get(c).map(|c| &c.name).or_else(|| Some(&ocp.norm_constraints.get(c - path.len())?.name)).cloned()
            }
            Bounded::Input(_) => None,
        };
        found.iter().filter_map(|(of, largest)| Some((name(of)?, *largest))).collect()
    }

    /// Times of the states of [`LiveController::prediction`] since sample 0, s.
    pub fn prediction_times(&self) -> Vec<f64> {
        let first = self.answer.sample + self.delay;
        (0..=self.prediction().steps()).map(|k| self.problem.ocp.time(first, k)).collect()
    }

    /// What the estimator made of the last measurement; none where the states are measured.
    pub fn estimate(&self) -> Option<&Estimate> {
        self.controller.estimate()
    }

    /// The problem, with the changes made since.
    pub fn problem(&self) -> &ControlProblem {
        &self.problem
    }

    /// Sampling period in the unit of time of the model.
    pub fn period(&self) -> f64 {
        self.problem.ocp.dt
    }

    /// Sampling period, s; infinite where the time of the model has no unit.
    pub fn period_seconds(&self) -> f64 {
        self.problem.period_seconds()
    }

    /// Samples between a measurement and the input that answers it that the controller predicts over.
    pub fn compensated_delay(&self) -> usize {
        self.delay
    }

    /// Names of the states.
    pub fn states(&self) -> Vec<String> {
        self.problem.system.state_names()
    }

    /// Names of the inputs.
    pub fn inputs(&self) -> Vec<String> {
        self.problem.system.input_names()
    }

    /// Names of the entries of a measurement.
    pub fn measured(&self) -> Vec<String> {
        self.problem.measured()
    }

    /// Names of the references.
    pub fn references(&self) -> Vec<String> {
        self.problem.schedule.references.iter().filter(|r| !r.is_derivative()).map(name).collect()
    }

    /// Names of the parameters that can be changed.
    pub fn parameters(&self) -> Vec<String> {
        self.problem.schedule.parameters.iter().map(name).collect()
    }

    /// Names of the states that have a target.
    pub fn targets(&self) -> Vec<String> {
        let states = self.states();
        self.problem.ocp.targets.iter().map(|t| states[t.state].clone()).collect()
    }
}

fn name(scheduled: &Scheduled) -> String {
    scheduled.name.clone()
}
