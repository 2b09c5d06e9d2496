//! What went wrong in a run, and what to do about it.

use super::control_problem::ControlProblem;
use crate::closed_loop::ClosedLoop;
use crate::controller::{FallbackReason, StepStatus};
use crate::error::MpcError;
use crate::qp::QpStatus;
use bracketry_system::{System, counted, readable};

/// What the controller is told of inputs that act later than they are commanded.
fn note_on_delays(problem: &ControlProblem) -> Option<String> {
    let longest = |system: &System| system.delay_values().into_iter().flatten().fold(0.0, f64::max);
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
        FallbackReason::Linearization => (
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
