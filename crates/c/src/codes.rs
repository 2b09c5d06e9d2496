//! Codes, and what a sample tells.

use std::ffi::{CStr, c_char};

use bracketry_mpc::controller::{FallbackReason, InputSource, StepStatus};
use bracketry_mpc::live::LiveStep;
use bracketry_mpc::qp::QpStatus;

/// Whether a call worked.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BracketryCode {
    /// It worked.
    Ok = 0,
    /// A pointer is null, or not aligned.
    Null = 1,
    /// An array has another length than it has to have.
    Length = 2,
    /// A number that makes no sense here, such as NaN.
    Value = 3,
    /// A text is not UTF-8.
    Text = 4,
    /// The controller has nothing of that name.
    Name = 5,
    /// The time of a measurement cannot be used.
    Time = 6,
    /// The problem file, or a model that it names, is not as it has to be.
    Problem = 7,
    /// The controller cannot be made or cannot go on.
    Controller = 8,
    /// A bug in the library. The controller can only be freed.
    Panic = 9,
}

/// Lists of names that a controller has.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BracketryKind {
    /// The states of the model: the entries of x.
    State = 0,
    /// The inputs: the entries of u.
    Input = 1,
    /// What is measured: the entries of y.
    Measurement = 2,
    /// The references of cost and constraints.
    Reference = 3,
    /// The parameters that can be changed.
    Parameter = 4,
    /// The states that have a target.
    Target = 5,
}

/// How a sample went.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BracketryOutcome {
    /// A new input from a program solved to full accuracy.
    Solved = 0,
    /// A new input from a program solved to reduced accuracy.
    Inaccurate = 1,
    /// A new input, but a hard bound cannot be kept: the violation is as small as it can be.
    Infeasible = 2,
    /// The shrinking horizon is (nearly) used up: the plan is played out.
    PlayedOut = 3,
    /// The input of the failure policy.
    Fallback = 4,
}

/// Where an input comes from.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BracketrySource {
    /// A program solved for this measurement.
    Program = 0,
    /// A program solved ahead, moved to this measurement by the tangential predictor.
    Tangent = 1,
    /// The last usable plan, shifted.
    Plan = 2,
    /// The law that brakes.
    Brake = 3,
    /// The input of rest.
    Rest = 4,
}

/// Why the failure policy decided.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BracketryReason {
    /// It did not.
    None = 0,
    /// Nothing was measured: every entry of the measurement is NaN.
    LostSample = 1,
    /// The measurement has an entry that is not finite.
    Measurement = 2,
    /// The linearization has an entry that is not finite.
    Linearization = 3,
    /// The cost along the plan is not finite.
    Cost = 4,
    /// The time of the sample was over before there was a solution.
    TimeLimit = 5,
    /// The quadratic program reached its limit of iterations or time.
    QpLimit = 6,
    /// The quadratic program was not solved.
    QpFailed = 7,
}

/// What a sample tells besides the input.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BracketryStatus {
    /// Number of the sample, from 0.
    pub sample: u64,
    /// Samples before it that got no measurement.
    pub missed: u64,
    /// How it went.
    pub outcome: BracketryOutcome,
    /// Where the input comes from.
    pub source: BracketrySource,
    /// Why the failure policy decided.
    pub reason: BracketryReason,
    /// Time of the preparation, s.
    pub prepare_seconds: f64,
    /// Time from the measurement to the input, s.
    pub feedback_seconds: f64,
}

impl BracketryStatus {
    pub(crate) fn of(answer: &LiveStep) -> Self {
        let step = &answer.step;
        Self {
            sample: answer.sample as u64,
            missed: answer.missed as u64,
            outcome: match step.status {
                StepStatus::Solved => BracketryOutcome::Solved,
                StepStatus::Inaccurate => BracketryOutcome::Inaccurate,
                StepStatus::Infeasible => BracketryOutcome::Infeasible,
                StepStatus::PlayedOut => BracketryOutcome::PlayedOut,
                StepStatus::Fallback(_) => BracketryOutcome::Fallback,
            },
            source: match step.source {
                InputSource::Program => BracketrySource::Program,
                InputSource::Tangent => BracketrySource::Tangent,
                InputSource::Plan => BracketrySource::Plan,
                InputSource::Brake => BracketrySource::Brake,
                InputSource::Rest => BracketrySource::Rest,
            },
            reason: match step.status.fallback_reason() {
                None => BracketryReason::None,
                Some(FallbackReason::LostSample) => BracketryReason::LostSample,
                Some(FallbackReason::Measurement) => BracketryReason::Measurement,
                Some(FallbackReason::Linearization | FallbackReason::Qp(QpStatus::NotANumber)) => {
                    BracketryReason::Linearization
                }
                Some(FallbackReason::Cost) => BracketryReason::Cost,
                Some(FallbackReason::TimeLimit) => BracketryReason::TimeLimit,
                Some(FallbackReason::Qp(QpStatus::Limit)) => BracketryReason::QpLimit,
                Some(FallbackReason::Qp(_)) => BracketryReason::QpFailed,
            },
            prepare_seconds: step.timings.linearize,
            feedback_seconds: step.timings.feedback(),
        }
    }
}

/// The name of an outcome (a `BracketryOutcome`) as in other reports, such as `solved`; `unknown` for another number. Not to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn bracketry_outcome_name(outcome: u32) -> *const c_char {
    name(outcome, &[c"solved", c"inaccurate", c"infeasible", c"played_out", c"fallback"])
}

/// The name of a source (a `BracketrySource`), such as `program`; `unknown` for another number. Not to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn bracketry_source_name(source: u32) -> *const c_char {
    name(source, &[c"program", c"tangent", c"plan", c"brake", c"rest"])
}

/// The name of a reason (a `BracketryReason`), such as `lost_sample`; `unknown` for another number. Not to be freed.
#[unsafe(no_mangle)]
pub extern "C" fn bracketry_reason_name(reason: u32) -> *const c_char {
    let names =
        [c"none", c"lost_sample", c"measurement", c"linearization", c"cost", c"time_limit", c"qp_limit", c"qp_failed"];
    name(reason, &names)
}

fn name(number: u32, names: &[&'static CStr]) -> *const c_char {
    names.get(number as usize).copied().unwrap_or(c"unknown").as_ptr()
}
