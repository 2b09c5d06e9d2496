//! What is to be said about a closed-loop run.

use super::chance::ChanceReport;
use super::found_values::FoundValues;
use super::method::MethodReason;
use super::notes::Note;
use super::rounding::RoundingReport;
use super::scenarios::ScenarioReport;
use crate::closed_loop::{Counts, LateSamples, SolveTimes};
use crate::controller::SolverEffort;
use crate::ocp::BoundSide;
use crate::sqp::{Hessian, Solution};
use bracketry_symbolic::Named;
use bracketry_system::TimeUnit;
use serde::Serialize;

/// The plan that was made before the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanReport {
    /// How the solution process ended.
    pub status: String,
    /// Steps of the interior-point method, before the programs that confirm where it ends.
    pub interior_point_steps: usize,
    /// Number of quadratic programs.
    pub programs: usize,
    /// Second derivatives of the last program: `gauss-newton` or `exact`.
    pub hessian: Hessian,
    /// Largest mismatch between intervals, in units of the state scales.
    pub defect: f64,
    /// Time taken, s.
    pub seconds: f64,
}

impl PlanReport {
    pub(super) fn of(plan: &Solution) -> Self {
        Self {
            status: plan.status.to_string(),
            interior_point_steps: plan.interior_point_steps,
            programs: plan.iterations.len(),
            hessian: plan.hessian,
            defect: plan.defect,
            seconds: plan.seconds,
        }
    }
}

/// The bounds of an input to which the model gives a range: this range, with the ends that the problem gives instead.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeptRange {
    /// The input.
    pub input: String,
    /// Smallest value; none if there is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// Largest value; none if there is no limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// Which bound or named constraint is violated most, and where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ViolationReport {
    /// The state, input, or constraint; a constraint without a name has its number.
    pub name: String,
    /// Which of its bounds.
    pub side: BoundSide,
    /// The sample, from 0.
    pub sample: usize,
    /// Its time, s.
    pub time: f64,
}

/// Figures of a closed-loop run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosedLoopReport {
    /// The method, as problem files name it.
    pub method: &'static str,
    /// Why it is this method.
    pub method_reason: MethodReason,
    /// Σ dt·stage cost at the sampled states with the applied inputs.
    pub closed_loop_cost: f64,
    /// Stage and terminal cost, as predicted from the initial state, of the first plan that an input is taken from: with
    /// [`Method::Rti`](super::Method::Rti) after its initial programs, else the converged one. NaN where there is no such plan.
    pub open_loop_cost: f64,
    /// The part of the stage cost in `open_loop_cost`: what compares with the closed-loop cost over a horizon.
    pub open_loop_stage_cost: f64,
    /// The part of the terminal cost in it.
    pub open_loop_terminal_cost: f64,
    /// The terminal cost of the state that the loop has at the end of the horizon of a plan; none where the horizon moves on, or the
    /// run ends before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub closed_loop_terminal_cost: Option<f64>,
    /// State at the end.
    pub x_final: Named<f64>,
    /// What is missing to every target at the end.
    #[serde(skip_serializing_if = "Named::is_empty")]
    pub miss: Named<f64>,
    /// Number of samples.
    pub steps: usize,
    /// Outcomes of the samples.
    pub status: Counts,
    /// What was solved for the plan and for all samples; not what was solved to choose the method or among starts, nor for free values.
    pub effort: SolverEffort,
    /// Times per sample.
    pub solve_ms: SolveTimes,
    /// Samples that took longer than the sampling period.
    pub late: LateSamples,
    /// Sampling period, ms; infinite where the time of the model has no unit.
    pub period_ms: f64,
    /// The same in the unit of time of the model.
    #[serde(skip)]
    pub period: f64,
    /// The unit of all other times.
    #[serde(skip_serializing_if = "TimeUnit::is_second")]
    pub time_unit: TimeUnit,
    /// Largest violation of a bound or named constraint, each in its own unit.
    pub constraint_violation_max: f64,
    /// Which one it is, and where; none where all are kept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub constraint_violation_at: Option<ViolationReport>,
    /// Inputs that are kept within ranges of the model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub input_ranges: Vec<KeptRange>,
    /// The end time and parameters that were free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found: Option<FoundValues>,
    /// The scenario tree, where parameters are uncertain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scenarios: Option<ScenarioReport>,
    /// The margins of bounds that hold with a probability.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chance: Option<ChanceReport>,
    /// Inputs of finite sets, and what rounding to them costs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rounding: Option<RoundingReport>,
    /// The plan, where one was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanReport>,
    /// What went wrong: how often, where first, and what to do about it.
    pub notes: Vec<Note>,
    /// Whether the run did what was asked: every target met within its tolerance (without targets, or where the run ends before
    /// the horizon: the plan, where there is
    /// one, converged), no sample infeasible or fallen back on an old input, every figure finite, and no note that speaks
    /// against it ([`Note::is_failure`]).
    pub succeeded: bool,
}
