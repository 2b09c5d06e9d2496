//! A control problem run from start to end, and what is to be said about it.

use super::conditions::RunConditions;
use super::control_problem::ControlProblem;
use super::findings::findings;
use super::method::Method;
use super::notes::Note;
use super::report::{ClosedLoopReport, KeptRange, PlanReport, ViolationReport};
use super::start::Started;
use super::verdict::verdict;
use crate::closed_loop::{ClosedLoop, LateSamples, LoopSettings, MeasurementFunction, Plant, run_closed_loop};
use crate::error::MpcError;
use crate::ocp::{Bounded, ConstraintTrace, LargestViolation};
use crate::sqp::{Solution, SolveStatus};
use crate::trajectory::PlannedTrajectory;
use bracketry_system::InputRange;
use rand::SeedableRng;
use rand::rngs::StdRng;
use rand_distr::{Distribution, StandardNormal};

/// A run with its figures.
#[derive(Clone, Debug)]
pub struct ControlRun {
    /// The figures.
    pub report: ClosedLoopReport,
    /// Sampled states and inputs.
    pub closed_loop: ClosedLoop,
    /// The plan, where one was made.
    pub plan: Option<Solution>,
    /// The path constraints, then the norm constraints, along the run.
    pub constraints: Vec<ConstraintTrace>,
}

impl ControlProblem {
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
        if self.has_free_values() {
            return self.with_free_values()?.run_disturbed(plant, disturb);
        }
        if !self.has_run {
            return Err(MpcError::NoRun);
        }
        let Started { problem, mut controller, plan, predicted, .. } = self.started()?;
        let first_plan = controller.plan().clone();
        let mut disturb = disturb;
        let mut noise = Noise::new(&self.conditions);
        let mut outputs = self.estimation.as_ref().map(|e| e.outputs(&self.plant)).transpose()?;
        let settings = LoopSettings {
            measurement: outputs
                .as_mut()
                .map(|h| Box::new(|t: f64, x: &[f64]| h.values(x, &[], t, &[]).to_vec()) as MeasurementFunction<'_>),
            noise: Some(Box::new(move |k, y| {
                noise.add(y);
                disturb(k, y);
            })),
            delay: self.conditions.delay,
            initial_input: self.first_input(),
            keep_predictions: self.conditions.keep_predictions,
            faults: Some(Box::new(|k| self.conditions.faults_at(k))),
            stop: self.stop.clone(),
        };
        let run = run_closed_loop(controller.as_mut(), plant, &self.x0, self.samples, settings)?;
        let end = run.x.last().unwrap_or(&self.x0);
        let names = self.system.state_names();
        let found = self.found.as_ref().is_none_or(|f| f.converged);
        let planned = found && plan.as_ref().is_none_or(|p| p.status == SolveStatus::Converged);
        // The linear weight of a target is the inverse of its tolerance. A run that ends before the horizon does not get there.
        let met =
            self.ends_early() || self.ocp.targets.iter().all(|t| (end[t.state] - t.value).abs() * t.linear <= 1.0);
        let finite = end.iter().chain([&run.cost, &predicted.total()]).all(|v| v.is_finite());
        // Costs and constraints are functions of the previous inputs too.
        let judged = problem.with_previous(&run);
        let judged = judged.as_ref().unwrap_or(&run);
        let mut notes = findings(&problem, &run, predicted.total());
        notes.extend(verdict(&problem, judged, &problem.plan_with_previous(&first_plan), planned, predicted)?);
        let rounding = problem.rounding_report(controller.as_ref(), judged)?;
        notes.extend(rounding.as_ref().and_then(|r| problem.note_on_rounding(r)));
        let succeeded = finite
            && !notes.iter().any(Note::is_failure)
            && run.counts.infeasible + run.counts.fallback == 0
            && if self.ocp.targets.is_empty() || self.ends_early() { planned } else { met };
        let mut ocp = self.ocp.clone();
        let constraints = ocp.constraint_traces(&judged.x, &run.u);
        let violation = ocp.worst_violation(&judged.x, &run.u, &constraints);
        let steps = ocp.steps;
        let tracked = matches!(problem.method, Method::Plan { .. }) && ocp.is_uniform() && run.u.len() >= steps;
        let at_end = tracked.then(|| ocp.terminal_cost(steps, run.t[steps], &judged.x[steps]));
        let report = ClosedLoopReport {
            succeeded,
            notes,
            method: problem.method.name(),
            method_reason: problem.method_reason,
            closed_loop_cost: run.cost,
            open_loop_cost: predicted.total(),
            open_loop_stage_cost: predicted.stage,
            open_loop_terminal_cost: predicted.terminal,
            closed_loop_terminal_cost: at_end,
            x_final: names.iter().cloned().zip(end.iter().copied()).collect(),
            miss: self.ocp.targets.iter().map(|t| (names[t.state].clone(), end[t.state] - t.value)).collect(),
            steps: run.steps.len(),
            status: run.counts,
            effort: plan.iter().map(Solution::effort).chain(run.steps.iter().map(|s| s.effort)).sum(),
            solve_ms: run.times,
            late: self.late_samples(&run),
            period_ms: 1e3 * self.period_seconds(),
            period: self.ocp.dt,
            time_unit: self.system.quantities.time_unit,
            constraint_violation_max: violation.map_or(0.0, |v| v.by),
            constraint_violation_at: violation.map(|v| self.violated(&v, &constraints, run.t[v.sample])),
            input_ranges: self.kept_ranges(),
            found: self.found.clone(),
            rounding,
            chance: self.chance.clone(),
            scenarios: self.scenarios.as_ref().map(|tree| tree.report(controller.figures().predicted_violation)),
            plan: plan.as_ref().map(PlanReport::of),
        };
        Ok(ControlRun { report, closed_loop: run, plan, constraints })
    }

    /// The run with the previous inputs among its states; none where the problem has no previous inputs.
    fn with_previous(&self, run: &ClosedLoop) -> Option<ClosedLoop> {
        let mut run = (!self.ocp.previous_inputs.is_empty()).then(|| run.clone())?;
        run.x = self.ocp.with_previous(&run.x, &run.u, &self.first_input());
        Some(run)
    }

    /// A plan from the initial state with the previous inputs among its states.
    fn plan_with_previous(&self, plan: &PlannedTrajectory) -> PlannedTrajectory {
        let rows = |count: usize, row: &dyn Fn(usize) -> Vec<f64>| (0..count).map(row).collect::<Vec<_>>();
        let x = rows(plan.steps() + 1, &|k| plan.x(k).to_vec());
        let u = rows(plan.steps(), &|k| plan.u(k).to_vec());
        let x = self.ocp.with_previous(&x, &u, &self.first_input());
        PlannedTrajectory::from_rows(&x, &u).unwrap_or_else(|_| plan.clone())
    }

    /// Whether the run ends before the end of the first horizon, where the targets are.
    pub(super) fn ends_early(&self) -> bool {
        self.samples < self.ocp.samples_of_horizon()
    }

    /// Samples that took longer than the sampling period.
    fn late_samples(&self, run: &ClosedLoop) -> LateSamples {
        let mut late = LateSamples::default();
        run.steps.iter().for_each(|step| late.add(step.timings.total(), self.period_seconds()));
        late
    }

    /// The name of what is violated, and where it is.
    fn violated(&self, v: &LargestViolation, constraints: &[ConstraintTrace], time: f64) -> ViolationReport {
        let name = match v.of {
            Bounded::State(i) => self.system.state_names().get(i).cloned(),
            Bounded::Input(j) => self.system.input_names().get(j).cloned(),
            Bounded::Constraint(c) => constraints.get(c).map(|c| c.name.clone()).filter(|name| !name.is_empty()),
        };
        let number = |c: usize| format!("constraint {}", c + 1);
        let (Bounded::State(c) | Bounded::Input(c) | Bounded::Constraint(c)) = v.of;
        ViolationReport { name: name.unwrap_or_else(|| number(c)), side: v.side, sample: v.sample, time }
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
