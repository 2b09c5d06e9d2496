//! What went wrong in a run, and what to do about it.

use std::fmt;

use serde::{Serialize, Serializer};

use super::control_problem::ControlProblem;
use crate::closed_loop::ClosedLoop;
use crate::controller::{FallbackReason, StepStatus};
use crate::error::MpcError;
use crate::qp::QpStatus;
use bracketry_system::{System, counted, readable};

/// Where something happened first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstSample {
    /// Index of the sample.
    pub index: usize,
    /// Its time, s.
    pub time: f64,
}

/// What is to be said of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// A state of the plant is not finite.
    State {
        /// The state.
        name: String,
        /// Where first.
        first: FirstSample,
    },
    /// Inputs act later than they are commanded.
    Delays {
        /// The longest delay of the plant, s.
        longest: f64,
        /// The same in samples.
        samples: f64,
        /// Samples that the controller predicts over.
        compensated: usize,
    },
    /// The stage cost is not finite.
    StageCost {
        /// Where first.
        first: FirstSample,
    },
    /// The estimator's outputs do not tell everything.
    Unobservable {
        /// What they do not tell.
        names: Vec<String>,
    },
    /// The first plan failed.
    NoPlan,
    /// The failure policy chose the input.
    Fallback {
        /// Why.
        reason: FallbackReason,
        /// Number of samples.
        count: usize,
        /// The first of them.
        first: FirstSample,
    },
    /// A hard bound cannot be kept.
    Infeasible {
        /// Number of samples.
        count: usize,
        /// The first of them.
        first: FirstSample,
    },
    /// The tolerance is not reached.
    Inaccurate {
        /// Number of samples.
        count: usize,
        /// The first of them.
        first: FirstSample,
    },
}

impl fmt::Display for FirstSample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at sample {} (t = {} s)", self.index, readable(self.time))
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Note::State { name, first } => write!(
                f,
                "the plant's state `{name}` is not finite {first}: bound the inputs, or take a shorter dt or more \
                 plant_substeps"
            ),
            Note::Delays { longest, samples, compensated } => write!(
                f,
                "the plant's inputs act up to {} s ({samples:.2} samples) later than commanded; the controller predicts \
                 over {} of it",
                readable(*longest),
                counted(*compensated, "sample", "samples")
            ),
            Note::StageCost { first } => write!(
                f,
                "the stage cost is not finite {first}: write one that is defined at every state that the loop passes"
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
                "{count} × infeasible: a hard bound cannot be kept; make it soft, or give the inputs more room or the loop \
                 another start, first {first}"
            ),
            Note::Inaccurate { count, first } => write!(
                f,
                "{count} × inaccurate: the tolerance is not reached; give [scale], a [guess] or more max_iterations, first \
                 {first}"
            ),
        }
    }
}

impl Serialize for Note {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// What the controller is told of inputs that act later than they are commanded.
fn note_on_delays(problem: &ControlProblem) -> Option<Note> {
    let longest = |system: &System| system.delay_values().into_iter().flatten().fold(0.0, f64::max);
    let (plant, model) = (longest(&problem.plant), longest(&problem.system));
    if plant == 0.0 && model == 0.0 {
        return None;
    }
    let compensated = match problem.delay_of_inputs() {
        Ok(samples) if problem.conditions.compensate_delay => samples,
        _ => 0,
    };
    Some(Note::Delays { longest: plant, samples: plant / problem.ocp.dt, compensated })
}

/// What went wrong in a run: quantities that are not finite, then samples without a good solution; and what the
/// controller is told of delays.
pub(super) fn notes(problem: &ControlProblem, run: &ClosedLoop, open_loop_cost: f64) -> Vec<Note> {
    let mut notes = Vec::new();
    let sample = |k: usize| FirstSample { index: k, time: run.t[k] };
    let names = problem.system.state_names();
    let mut states = run.x.iter().enumerate();
    if let Some((k, i)) = states.find_map(|(k, x)| x.iter().position(|v| !v.is_finite()).map(|i| (k, i))) {
        notes.push(Note::State { name: names[i].clone(), first: sample(k) });
    }
    notes.extend(note_on_delays(problem));
    let mut ocp = problem.ocp.clone();
    let mut inputs = run.u.iter().enumerate();
    if let Some((k, _)) = inputs.find(|&(k, u)| !ocp.stage_cost(k, run.t[k], &run.x[k], u).is_finite()) {
        notes.push(Note::StageCost { first: sample(k) });
    }
    if let Some(estimation) = &problem.estimation {
        // What moves nowhere on the way cannot be told; at some points alone anything may be hidden.
        let samples = run.u.len();
        let hidden = [0, samples / 3, 2 * samples / 3]
            .map(|k| estimation.problem.check_observability(&run.x[k], &run.u[k]).err());
        if let [Some(_), Some(_), Some(MpcError::NotObservable { names })] = hidden {
            notes.push(Note::Unobservable { names });
        }
    }
    if !open_loop_cost.is_finite() {
        notes.push(Note::NoPlan);
    }
    // One note per reason, in the order of their appearance.
    let mut fallbacks: Vec<(FallbackReason, usize, usize)> = Vec::new();
    for (k, step) in run.steps.iter().enumerate() {
        if let StepStatus::Fallback(reason) = step.status {
            match fallbacks.iter_mut().find(|f| f.0 == reason) {
                Some(f) => f.1 += 1,
                None => fallbacks.push((reason, 1, k)),
            }
        }
    }
    let fallback = |(reason, count, k)| Note::Fallback { reason, count, first: sample(k) };
    notes.extend(fallbacks.into_iter().map(fallback));
    let first = |status: StepStatus| run.steps.iter().position(|s| s.status == status).map(sample);
    let infeasible = first(StepStatus::Infeasible);
    notes.extend(infeasible.map(|first| Note::Infeasible { count: run.counts.infeasible, first }));
    let inaccurate = first(StepStatus::Inaccurate);
    notes.extend(inaccurate.map(|first| Note::Inaccurate { count: run.counts.inaccurate, first }));
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
