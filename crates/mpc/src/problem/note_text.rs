//! Notes as text.

use super::cause::Cause;
use super::notes::{FirstSample, Note};
use crate::closed_loop::Refined;
use crate::controller::FallbackReason;
use crate::error::MpcError;
use crate::qp::QpStatus;
use bracketry_system::{counted, readable};
use std::fmt;

impl fmt::Display for FirstSample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at sample {} (t = {})", self.index, readable(self.time))
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::State { name, first } => write!(
                f,
                "the plant's state `{name}` is not finite {first}: bound the inputs, or use a shorter dt or more \
                 plant_substeps"
            ),
            Note::Diverges { name, value, size, in_plan: true } => write!(
                f,
                "the plan reaches `{name}` = {}, far beyond its size {}: the cost seems to have no lower bound; \
                 bound the inputs, or make the cost grow with all of them",
                readable(*value),
                readable(*size)
            ),
            Note::Diverges { name, value, size, in_plan: false } => write!(
                f,
                "the run reaches `{name}` = {}, far beyond its size {}: the loop is unstable; compare the plant with \
                 the model, or use a shorter dt or a longer horizon",
                readable(*value),
                readable(*size)
            ),
            Note::PlantRefined(Refined { sample, time, substeps, error }) => write!(
                f,
                "the plant is simulated with error control from sample {sample} (t = {}) on: {} {}",
                readable(*time),
                counted(*substeps, "Runge–Kutta step", "Runge–Kutta steps"),
                if error.is_finite() {
                    format!("would be off by {} of the states' sizes", readable(*error))
                } else {
                    "would not give a finite number".to_owned()
                }
            ),
            Note::Eliminated(what) => write!(f, "{what}"),
            Note::Delays { longest, samples, compensated } => write!(
                f,
                "the plant's inputs act up to {samples:.2} samples (a time of {}) later than commanded; the controller \
                 predicts over a delay of {}",
                readable(*longest),
                counted(*compensated, "sample", "samples")
            ),
            Note::RoundingCosts { relaxed, rounded } => write!(
                f,
                "inputs from finite sets cost {} over the horizon, and relaxed inputs {}: use a shorter dt or more values",
                readable(*rounded),
                readable(*relaxed)
            ),
            Note::TableEnds { name, last, end } => write!(
                f,
                "the table of `{name}` ends at t = {}, and the run at t = {}: the last value is held afterwards",
                readable(*last),
                readable(*end)
            ),
            Note::OneRow { name } => {
                write!(f, "the table of `{name}` has one row: its value is constant; give more rows, or write a number")
            }
            Note::UnusedReference { name } => write!(
                f,
                "the reference `{name}` is unused: use it in the cost, such as (x - {name})^2, or remove it"
            ),
            Note::LongInterval { dt, time_constant } => write!(
                f,
                "an interval of {} is {} times as long as the time constant of the model's motion, {}: is dt in the unit of time of \
                 the model?",
                readable(*dt),
                readable((dt / time_constant).round()),
                readable(*time_constant)
            ),
            Note::StartsOutside { state, value, bounds } => write!(
                f,
                "the run starts with `{state}` = {} outside its hard bounds {} to {}: start within them, or make them soft",
                readable(*value),
                readable(bounds.0),
                readable(bounds.1)
            ),
            Note::Held { names } => write!(
                f,
                "nothing moves: friction (sign of {}) holds against each input alone at both bounds; widen the bounds",
                names.join(", ")
            ),
            Note::TargetsLater { run, horizon, reached } => write!(
                f,
                "the run ends at t = {}, before the horizon, at whose end, t = {}, the targets are{}",
                readable(*run),
                readable(*horizon),
                if *reached { "; the plan reaches them" } else { "" }
            ),
            Note::SearchNotConverged { status, programs } => write!(
                f,
                "the search for free values {status} after {}: the values found are approximate; use them as guesses",
                counted(*programs, "quadratic program", "quadratic programs")
            ),
            Note::PlanMisses { state, miss } => write!(
                f,
                "the plan misses the target of `{state}` by {}: {}",
                readable(*miss),
                Cause::LocalMinimum
            ),
            Note::BeyondRange { input, bounds, range } => write!(
                f,
                "the bounds of `{input}`, {} to {}, exceed its range in the model, {} to {}: narrow the bounds, or \
                 widen [ranges]",
                readable(bounds.0),
                readable(bounds.1),
                readable(range.0),
                readable(range.1)
            ),
            Note::StageCost { first } => write!(
                f,
                "the stage cost is not finite {first}: write a cost that is defined at every state of the run"
            ),
            Note::Unobservable { names } => fmt::Display::fmt(&MpcError::NotObservable { names: names.clone() }, f),
            Note::NoPlan => f.write_str(
                "the predicted cost is not finite: the first plan failed; give a [guess], or a cost defined at its states",
            ),
            Note::Fallback { reason, count, first } => {
                let (what, remedy) = explained(*reason);
                write!(f, "{count} × fallback, first {first}: {what}; {remedy}")
            }
            Note::Infeasible { count, first } => write!(
                f,
                "{count} × infeasible: a hard bound cannot be kept; make it soft, widen the input bounds, or start \
                 elsewhere; first {first}"
            ),
            Note::MostlyInaccurate { count, of } => write!(
                f,
                "{count} of {} do not reach the tolerance: the inputs are not optimal; give a [guess], or [scale] \
                 near the real sizes",
                counted(*of, "sample", "samples")
            ),
            Note::PlanNotConverged => f.write_str("the plan did not converge: give a [guess], or raise max_iterations"),
            Note::ChosenWithoutPlan => f.write_str(
                "no plan converged, and the method is one QP per sample: the inputs may be far from optimal; give a [guess], \
                 or [scale] near the real sizes, or write a smooth cost",
            ),
            Note::NotHeld { count, reached, left } => write!(
                f,
                "after the plan ends, rest inputs ({}) do not hold the reached state: the stage cost goes from {} to \
                 {}; lengthen the horizon, give [solve] rest, or use another method",
                counted(*count, "sample", "samples"),
                readable(*reached),
                readable(*left)
            ),
            Note::Grows { first, last, cause } => write!(
                f,
                "the stage cost grows from {} in the first quarter of the run to {} in the last: {cause}",
                readable(*first),
                readable(*last)
            ),
            Note::MissedTarget { state, miss, cause } => {
                write!(f, "the target of `{state}` is missed by {}: {cause}", readable(*miss))
            }
            Note::UnlikePlan { realized, planned, intervals, cause } => write!(
                f,
                "the first {} cost {}, but {} in the plan: {cause}",
                counted(*intervals, "interval", "intervals"),
                readable(*realized),
                readable(*planned)
            ),
            Note::EndCostStays { first, last, planned, cause } => write!(
                f,
                "the terminal cost goes from {} to {} over the run, but to {} in the plan: {cause}",
                readable(*first),
                readable(*last),
                readable(*planned)
            ),
            Note::Outdone { stays, input, value, intervals, cost, realized } => {
                let what = if *stays { "the inputs stay at their guess" } else { "a simple input does better" };
                write!(
                    f,
                    "{what}: over the horizon, the inputs cost {}; holding {input} = {} for {}, then rest, costs {}; \
                     give a [guess] near it",
                    readable(*realized),
                    readable(*value),
                    counted(*intervals, "interval", "intervals"),
                    readable(*cost)
                )
            }
            Note::BetterElsewhere { at_rest, planned, found } => write!(
                f,
                "the plan is only a local minimum: it costs {}, whereas a plan started from {} costs {}; give such a [guess]",
                readable(*planned),
                if *at_rest { "inputs at rest" } else { "a wave of 10 % on the guess" },
                readable(*found)
            ),
            Note::Singular { name, length, first } => write!(
                f,
                "the direction of ({name}) is used where its length is {} {first}; it is smooth except at length 0; \
                 write unit(…) for friction",
                readable(*length)
            ),
            Note::EstimateOff { state, error, deviations, ruined } => write!(
                f,
                "the estimate of `{state}` is off by {} in the last quarter of the run, {} standard deviations of the estimator{}: \
                 raise process_noise or initial_std, estimate a disturbance, or measure more",
                readable(*error),
                readable(deviations.round()),
                if *ruined { "; the controller acts on a wrong state" } else { "" }
            ),
            Note::NotSettling { last, planned, cause } => write!(
                f,
                "the stage cost is {} in the last quarter of the run, but in the plan it falls to {}: {cause}",
                readable(*last),
                readable(*planned)
            ),
            Note::Inaccurate { count, first } => write!(
                f,
                "{count} × inaccurate: the tolerance is not reached; give [scale], a [guess], or more \
                 max_iterations; first {first}"
            ),
        }
    }
}

/// What is behind a fallback, and what to do about it.
fn explained(reason: FallbackReason) -> (&'static str, &'static str) {
    match reason {
        FallbackReason::LostSample => ("the measurement is missing", "[solve] policy sets the input in this case"),
        FallbackReason::Measurement => (
            "a measured value is not finite",
            "[solve] policy sets the input in this case; an estimator bridges the gap",
        ),
        FallbackReason::Linearization => (
            "the model or one of its derivatives is not finite along the plan",
            "bound the states to where the equations are defined, give a [guess], or use a shorter dt",
        ),
        FallbackReason::Cost => (
            "the cost is not finite along the plan",
            "write a cost that is defined at every state, or bound the states to where it is defined",
        ),
        FallbackReason::TimeLimit => {
            ("the time limit was exceeded", "raise the time limit, or use fewer steps in [horizon]")
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
