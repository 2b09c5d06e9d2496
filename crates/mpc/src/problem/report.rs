//! What is to be said about a closed-loop run.

use super::ControlProblem;
use crate::closed_loop::ClosedLoop;
use crate::counts::{Counts, SolveTimes};
use crate::error::MpcError;
use crate::qp::QpStatus;
use crate::sqp::SolveStatus;
use crate::step::{FallbackReason, StepStatus};
use bracketry_system::{System, counted, readable};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use std::fmt;

/// The plan that was made before the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanReport {
    /// How the solution process ended.
    pub status: String,
    /// Number of quadratic programs.
    pub programs: usize,
    /// Largest mismatch between intervals, in units of the state scales.
    pub defect: f64,
    /// Time taken, s.
    pub seconds: f64,
}

/// Values of states by name, in the order of the model; as JSON one object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedValues(Vec<(String, f64)>);

impl NamedValues {
    /// The value of a name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// Names and values, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(name, value)| (name.as_str(), *value))
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl FromIterator<(String, f64)> for NamedValues {
    fn from_iter<I: IntoIterator<Item = (String, f64)>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}

impl Serialize for NamedValues {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in self.iter() {
            map.serialize_entry(name, &value)?;
        }
        map.end()
    }
}

/// Figures of a closed-loop run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ControlReport {
    /// Σ dt·stage cost at the sampled states with the applied inputs.
    pub closed_loop_cost: f64,
    /// Stage and terminal cost, as predicted from the initial state, of the first plan that an input is taken from: with
    /// [`Method::Rti`](super::Method::Rti) after its initial programs, else the converged one. NaN where there is no such plan.
    pub open_loop_cost: f64,
    /// State at the end.
    pub x_final: NamedValues,
    /// What is missing to every target at the end.
    #[serde(skip_serializing_if = "NamedValues::is_empty")]
    pub miss: NamedValues,
    /// Number of samples.
    pub steps: usize,
    /// Outcomes of the samples.
    pub status: Counts,
    /// Times per sample.
    pub solve_ms: SolveTimes,
    /// Sampling period, ms.
    pub period_ms: f64,
    /// Largest violation of a bound or named constraint, each in its own unit.
    pub constraint_violation_max: f64,
    /// The plan, where one was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanReport>,
    /// What went wrong: how often, where first, and what to do about it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Whether the run did what was asked: every target met within its tolerance (without targets: the plan, where there is
    /// one, converged), no sample infeasible or fallen back on an old input, and every figure finite.
    pub succeeded: bool,
}

impl fmt::Display for ControlReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(p) = &self.plan {
            let programs = counted(p.programs, "quadratic program", "quadratic programs");
            writeln!(f, "plan           {}, {programs} in {:.2} s", p.status, p.seconds)?;
        }
        let (cost, predicted) = (readable(self.closed_loop_cost), readable(self.open_loop_cost));
        writeln!(f, "cost           {cost} in closed loop, {predicted} predicted")?;
        let c = &self.status;
        writeln!(
            f,
            "samples        {}: {} solved, {} inaccurate, {} infeasible, {} fallback, {} after the plan's end",
            self.steps, c.solved, c.inaccurate, c.infeasible, c.fallback, c.played_out
        )?;
        let s = &self.solve_ms;
        writeln!(
            f,
            "step time      {:.2} ms median, {:.2} ms 99 %, {:.2} ms longest; sampling period {} ms",
            s.median,
            s.p99,
            s.max,
            readable(self.period_ms)
        )?;
        writeln!(f, "bounds         violated by at most {}", readable(self.constraint_violation_max))?;
        let width = self.x_final.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max(8);
        for (name, v) in self.x_final.iter() {
            write!(f, "final {name:<width$} {}", readable(v))?;
            match self.miss.get(name) {
                Some(e) => writeln!(f, ", misses its target by {}", readable(e.abs()))?,
                None => writeln!(f)?,
            }
        }
        for note in &self.notes {
            writeln!(f, "note           {note}")?;
        }
        Ok(())
    }
}

/// What the controller is told of inputs that act later than they are commanded.
fn note_on_delays(problem: &ControlProblem) -> Option<String> {
    let longest = |system: &System| system.clone().delay_values().into_iter().flatten().fold(0.0, f64::max);
    let (plant, model) = (longest(&problem.plant), longest(&problem.system));
    if plant == 0.0 && model == 0.0 {
        return None;
    }
    let told = match problem.delay_of_inputs() {
        Ok(samples) if problem.conditions.compensate_delay => samples,
        _ => 0,
    };
    let dt = problem.ocp.dt;
    Some(format!(
        "the plant's inputs act up to {} s ({:.2} samples) later than commanded; the controller predicts over {} of it",
        readable(plant),
        plant / dt,
        counted(told, "sample", "samples")
    ))
}

/// What went wrong in a run, each with its remedy: quantities that are not finite, then samples without a good solution; and
/// what the controller is told of delays.
pub(super) fn notes(problem: &ControlProblem, run: &ClosedLoop, open_loop_cost: f64) -> Vec<String> {
    let mut notes = Vec::new();
    let place = |k: usize| format!("at sample {k} (t = {} s)", readable(run.t[k]));
    let names = problem.system.state_names();
    let mut states = run.x.iter().enumerate();
    if let Some((k, i)) = states.find_map(|(k, x)| x.iter().position(|v| !v.is_finite()).map(|i| (k, i))) {
        let name = &names[i];
        notes.push(format!(
            "the plant's state `{name}` is not finite {}: bound the inputs, or take a shorter dt or more plant_substeps",
            place(k)
        ));
    }
    notes.extend(note_on_delays(problem));
    let mut ocp = problem.ocp.clone();
    let mut inputs = run.u.iter().enumerate();
    if let Some((k, _)) = inputs.find(|&(k, u)| !ocp.stage_cost(k, run.t[k], &run.x[k], u).is_finite()) {
        notes.push(format!(
            "the stage cost is not finite {}: write one that is defined at every state that the loop passes",
            place(k)
        ));
    }
    if let Some(estimation) = &problem.estimation {
        // What moves nowhere on the way cannot be told; at some points alone anything may be hidden.
        let samples = run.u.len();
        let hidden = [0, samples / 3, 2 * samples / 3]
            .map(|k| estimation.problem.check_observability(&run.x[k], &run.u[k]).err());
        if let [Some(_), Some(_), Some(hidden @ MpcError::NotObservable { .. })] = hidden {
            notes.push(hidden.to_string());
        }
    }
    if !open_loop_cost.is_finite() {
        notes.push(
            "the predicted cost is not finite: the first plan failed; give a [guess], or a cost defined at its states"
                .to_owned(),
        );
    }
    // (reason, number of samples, first of them), in the order of their appearance.
    let mut fallbacks: Vec<(FallbackReason, usize, usize)> = Vec::new();
    for (k, step) in run.steps.iter().enumerate() {
        if let StepStatus::Fallback(reason) = step.status {
            match fallbacks.iter_mut().find(|f| f.0 == reason) {
                Some(f) => f.1 += 1,
                None => fallbacks.push((reason, 1, k)),
            }
        }
    }
    for (reason, count, first) in fallbacks {
        let (what, remedy) = explained(reason);
        notes.push(format!("{count} × fallback, first {}: {what}; {remedy}", place(first)));
    }
    for (status, count, what) in [
        (
            StepStatus::Infeasible,
            run.counts.infeasible,
            "infeasible: a hard bound cannot be kept; make it soft, or give the inputs more room or the loop another start",
        ),
        (
            StepStatus::Inaccurate,
            run.counts.inaccurate,
            "inaccurate: the tolerance is not reached; give [scale], a [guess] or more max_iterations",
        ),
    ] {
        if let Some(first) = run.steps.iter().position(|s| s.status == status) {
            notes.push(format!("{count} × {}, first {}", what, place(first)));
        }
    }
    notes
}

/// What is behind a fallback, and what to do about it.
fn explained(reason: FallbackReason) -> (&'static str, &'static str) {
    match reason {
        FallbackReason::LostSample => ("nothing was measured", "[solve] policy says what is applied then"),
        FallbackReason::Measurement => {
            ("a measured value is not finite", "[solve] policy says what is applied then; an estimator bridges it")
        }
        FallbackReason::Linearisation => (
            "the model or one of its derivatives is not finite along the plan",
            "bound the states to where the equations are defined, give a [guess], or take a shorter dt",
        ),
        FallbackReason::Cost => (
            "the cost is not finite along the plan",
            "write a cost that is defined at every state, or bound the states to where it is",
        ),
        FallbackReason::TimeLimit => {
            ("the time of the sample was over", "raise the time limit, or take fewer steps in [horizon]")
        }
        FallbackReason::Qp(QpStatus::Limit) => {
            ("a quadratic program reached its iteration limit", "raise qp_tolerance, or give [scale] and [trust]")
        }
        FallbackReason::Qp(_) => (
            "a quadratic program failed numerically",
            "give [scale] and [trust] near the real sizes, or make hard bounds soft",
        ),
    }
}

impl fmt::Display for SolveStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Converged => write!(f, "converged"),
            Self::Infeasible { violation } => {
                write!(f, "infeasible: a hard bound is violated by {violation:.3e} scales")
            }
            Self::IterationLimit => write!(f, "stopped at the iteration limit"),
            Self::Stalled => write!(f, "stalled: no step lowers the merit"),
            Self::QpFailed(s) => write!(f, "stopped: a quadratic program ended as {s:?}"),
            Self::NotANumber => write!(f, "stopped: a number is not finite"),
            Self::IntegratorFailed => write!(f, "stopped: an implicit integration step could not be solved"),
        }
    }
}
