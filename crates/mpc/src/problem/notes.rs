//! What went wrong in a run, and what to do about it.

use std::fmt;

use serde::{Serialize, Serializer};

use super::cause::Cause;
use crate::controller::FallbackReason;
use crate::error::MpcError;
use crate::qp::QpStatus;
use bracketry_system::{Eliminated, counted, readable};

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
    /// The plan or the run goes far beyond every size of the problem.
    Diverges {
        /// The state or input.
        name: String,
        /// The largest value that it takes.
        value: f64,
        /// Its size in the problem.
        size: f64,
        /// Whether it is the plan; else the run alone.
        in_plan: bool,
    },
    /// Something was eliminated from the controller's model when it was read.
    Eliminated(Eliminated),
    /// Inputs act later than they are commanded.
    Delays {
        /// The longest delay of the plant, s.
        longest: f64,
        /// The same in samples.
        samples: f64,
        /// Samples that the controller predicts over.
        compensated: usize,
    },
    /// A table of a reference or parameter ends before the run.
    TableEnds {
        /// The reference or parameter.
        name: String,
        /// Time of its last row, s.
        last: f64,
        /// End of the run, s.
        end: f64,
    },
    /// A table of a reference or parameter has one row: the quantity is constant.
    OneRow {
        /// The reference or parameter.
        name: String,
    },
    /// A reference is in no cost and no constraint.
    UnusedReference {
        /// Its name.
        name: String,
    },
    /// An interval is much longer than every motion of the model.
    LongInterval {
        /// Its length, s.
        dt: f64,
        /// Time constant of the slowest motion, or of the fastest growing one, s.
        time_constant: f64,
    },
    /// The run starts where a hard bound is violated.
    StartsOutside {
        /// The state.
        state: String,
        /// Its value at the start.
        value: f64,
        /// Its bounds.
        bounds: (f64, f64),
    },
    /// The run ends before the horizon, at whose end the targets are.
    TargetsLater {
        /// Length of the run, s.
        run: f64,
        /// Length of the horizon, s.
        horizon: f64,
        /// Whether the plan is known to reach them: it converged.
        reached: bool,
    },
    /// The search for a free end time and free parameters did not converge.
    SearchNotConverged {
        /// How it ended.
        status: String,
        /// Number of quadratic programs.
        programs: usize,
    },
    /// The plan misses a target.
    PlanMisses {
        /// The state.
        state: String,
        /// By how much.
        miss: f64,
    },
    /// The bounds of an input go beyond its range in the model.
    BeyondRange {
        /// The input.
        input: String,
        /// Its bounds.
        bounds: (f64, f64),
        /// Its range.
        range: (f64, f64),
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
    /// Most samples do not reach the tolerance.
    MostlyInaccurate {
        /// Number of samples that do not.
        count: usize,
        /// Number of all samples.
        of: usize,
    },
    /// The plan did not converge.
    PlanNotConverged,
    /// After the end of the plan, the inputs at rest do not hold what it reached.
    NotHeld {
        /// Number of samples after the end of the plan.
        count: usize,
        /// Stage cost at the end of the plan.
        reached: f64,
        /// Stage cost at the end of the run.
        left: f64,
    },
    /// The stage cost grows from the start of the run to its end.
    Grows {
        /// Mean of the first quarter of the samples.
        first: f64,
        /// Mean of the last quarter.
        last: f64,
        /// What probably lies behind it.
        cause: Cause,
    },
    /// A target is missed.
    MissedTarget {
        /// The state.
        state: String,
        /// By how much.
        miss: f64,
        /// What probably lies behind it.
        cause: Cause,
    },
    /// The loop costs much more than the plan that it starts with.
    UnlikePlan {
        /// Cost of the loop.
        realized: f64,
        /// Cost of the plan over the same intervals.
        planned: f64,
        /// Number of intervals.
        intervals: usize,
        /// What probably lies behind it.
        cause: Cause,
    },
    /// The terminal cost of the loop does not fall as that of its plan does.
    EndCostStays {
        /// That of the initial state.
        first: f64,
        /// That of the last state.
        last: f64,
        /// That of the end of the first plan.
        planned: f64,
        /// What probably lies behind it.
        cause: Cause,
    },
    /// A simple input does better than the plan.
    Outdone {
        /// Whether the inputs stay at their guess.
        stays: bool,
        /// The input that is held.
        input: String,
        /// Its value.
        value: f64,
        /// For how many intervals; afterwards it is at rest.
        intervals: usize,
        /// What this costs over the horizon.
        cost: f64,
        /// What the plan costs over the horizon; with one program per sample, what the loop does.
        realized: f64,
    },
    /// A plan from another start costs much less.
    BetterElsewhere {
        /// Whether the start are inputs at rest; else waves around the guess.
        at_rest: bool,
        /// What the plan costs.
        planned: f64,
        /// What the other plan costs.
        found: f64,
    },
    /// Inputs of finite sets cost much more than inputs between their values.
    RoundingCosts {
        /// What the first plan costs over the horizon, before its inputs are rounded.
        relaxed: f64,
        /// What its rounded inputs cost, or the run over the same time, whichever is more.
        rounded: f64,
    },
    /// The run comes close to where the equations have no value.
    Singular {
        /// The components of the vector whose direction they use.
        name: String,
        /// Its smallest length.
        length: f64,
        /// Where.
        first: FirstSample,
    },
    /// Nothing moves, and no input alone would move anything.
    Held {
        /// The switching functions of the friction that holds.
        names: Vec<String>,
    },
    /// The estimate of a state is far from the truth at the end of the run, by many of the standard deviations that the estimator states.
    EstimateOff {
        /// The state.
        state: String,
        /// Root of the mean square of the error over the last quarter of the samples.
        error: f64,
        /// The same in standard deviations.
        deviations: f64,
        /// Whether it is as large as half of the size of the state.
        ruined: bool,
    },
    /// The stage cost stays far above what the plan falls to.
    NotSettling {
        /// Mean of the last quarter of the samples.
        last: f64,
        /// Mean of the last quarter of the plan.
        planned: f64,
        /// What probably lies behind it.
        cause: Cause,
    },
    /// The tolerance is not reached.
    Inaccurate {
        /// Number of samples.
        count: usize,
        /// The first of them.
        first: FirstSample,
    },
}

impl Note {
    /// Whether a run with this note did not do what was asked.
    pub fn is_failure(&self) -> bool {
        match self {
            Self::MostlyInaccurate { .. }
            | Self::PlanNotConverged
            | Self::NotHeld { .. }
            | Self::Grows { .. }
            | Self::NotSettling { .. }
            | Self::EstimateOff { ruined: true, .. }
            | Self::MissedTarget { .. }
            | Self::PlanMisses { .. }
            | Self::UnlikePlan { .. }
            | Self::EndCostStays { .. }
            | Self::Outdone { .. }
            | Self::BetterElsewhere { .. }
            | Self::Held { .. }
            | Self::Diverges { .. }
            | Self::State { .. }
            | Self::StageCost { .. }
            | Self::NoPlan
            | Self::Fallback { .. }
            | Self::Infeasible { .. } => true,
            Self::Eliminated(_)
            | Self::Delays { .. }
            | Self::TableEnds { .. }
            | Self::OneRow { .. }
            | Self::UnusedReference { .. }
            | Self::LongInterval { .. }
            | Self::StartsOutside { .. }
            | Self::TargetsLater { .. }
            | Self::SearchNotConverged { .. }
            | Self::BeyondRange { .. }
            | Self::RoundingCosts { .. }
            | Self::Unobservable { .. }
            | Self::Singular { .. }
            | Self::EstimateOff { .. }
            | Self::Inaccurate { .. } => false,
        }
    }
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
            Note::Diverges { name, value, size, in_plan: true } => write!(
                f,
                "the plan goes to `{name}` = {}, where {} is its size: the cost seems to have no lower bound; bound the inputs, or \
                 make the cost grow with all of them",
                readable(*value),
                readable(*size)
            ),
            Note::Diverges { name, value, size, in_plan: false } => write!(
                f,
                "the run goes to `{name}` = {}, where {} is its size: the loop is unstable; compare the plant with the model, or take \
                 a shorter dt or a longer horizon",
                readable(*value),
                readable(*size)
            ),
            Note::Eliminated(what) => write!(f, "{what}"),
            Note::Delays { longest, samples, compensated } => write!(
                f,
                "the plant's inputs act up to {} s ({samples:.2} samples) later than commanded; the controller predicts \
                 over {} of it",
                readable(*longest),
                counted(*compensated, "sample", "samples")
            ),
            Note::RoundingCosts { relaxed, rounded } => write!(
                f,
                "inputs of finite sets cost {} over the horizon, inputs between their values {}: take a shorter dt, or more values",
                readable(*rounded),
                readable(*relaxed)
            ),
            Note::TableEnds { name, last, end } => write!(
                f,
                "the table of `{name}` ends at t = {} s, the run at t = {} s: afterwards the last value is kept",
                readable(*last),
                readable(*end)
            ),
            Note::OneRow { name } => {
                write!(f, "the table of `{name}` has one row: its value holds at all times; give more rows, or a number")
            }
            Note::UnusedReference { name } => write!(
                f,
                "nothing uses the reference `{name}`: write it in the cost, such as (x - {name})^2, or remove it"
            ),
            Note::LongInterval { dt, time_constant } => write!(
                f,
                "an interval of {} s is {} times as long as the time constant of the model's motion, {} s: is dt in seconds?",
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
                "nothing moves: friction holds (sign of {}) against every input alone, at both of its bounds; widen the bounds",
                names.join(", ")
            ),
            Note::TargetsLater { run, horizon, reached } => write!(
                f,
                "the run of {} s ends before the horizon of {} s, at whose end the targets are{}",
                readable(*run),
                readable(*horizon),
                if *reached { "; the plan reaches them" } else { "" }
            ),
            Note::SearchNotConverged { status, programs } => write!(
                f,
                "the search for what is free {status} after {}: the values found are approximate; start from them as guesses",
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
                "`{input}` may go from {} to {}, though its range in the model is {} to {}: narrow the bounds, or widen [ranges]",
                readable(bounds.0),
                readable(bounds.1),
                readable(range.0),
                readable(range.1)
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
            Note::MostlyInaccurate { count, of } => write!(
                f,
                "{count} of {} do not reach the tolerance: the inputs are no solutions; give a [guess], or [scale] near the real sizes",
                counted(*of, "sample", "samples")
            ),
            Note::PlanNotConverged => f.write_str("the plan did not converge: give a [guess], or raise max_iterations"),
            Note::NotHeld { count, reached, left } => write!(
                f,
                "{} after the end of the plan have the inputs at rest, which do not hold what it reached: the stage cost \
                 goes from {} to {}; lengthen the horizon, give [solve] rest, or take another method",
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
                "the first {} cost {}, where the plan has {}: {cause}",
                counted(*intervals, "interval", "intervals"),
                readable(*realized),
                readable(*planned)
            ),
            Note::EndCostStays { first, last, planned, cause } => write!(
                f,
                "the terminal cost goes from {} to {} over the run, where the plan ends at {}: {cause}",
                readable(*first),
                readable(*last),
                readable(*planned)
            ),
            Note::Outdone { stays, input, value, intervals, cost, realized } => {
                let what = if *stays { "the inputs stay at their guess" } else { "a simple input does better" };
                write!(
                    f,
                    "{what}: over the horizon they cost {}, {input} = {} for {} and then rest {}; give a [guess] near it",
                    readable(*realized),
                    readable(*value),
                    counted(*intervals, "interval", "intervals"),
                    readable(*cost)
                )
            }
            Note::BetterElsewhere { at_rest, planned, found } => write!(
                f,
                "the plan is a minimum that is only local: it costs {}, one from {} {}; give such a [guess]",
                readable(*planned),
                if *at_rest { "inputs at rest" } else { "a wave of 10 % on the guess" },
                readable(*found)
            ),
            Note::Singular { name, length, first } => write!(
                f,
                "the direction of ({name}) is taken where its length is {} {first}; it is smooth but where the length is 0, and \
                 friction only if written unit(…)",
                readable(*length)
            ),
            Note::EstimateOff { state, error, deviations, ruined } => write!(
                f,
                "the estimate of `{state}` is off by {} in the last quarter of the run, {} standard deviations of the estimator{}: \
                 raise process_noise or initial_std, estimate a disturbance, or measure more",
                readable(*error),
                readable(deviations.round()),
                if *ruined { "; the controller acts on another state than the plant's" } else { "" }
            ),
            Note::NotSettling { last, planned, cause } => write!(
                f,
                "the stage cost is {} in the last quarter of the run, where the plan falls to {}: {cause}",
                readable(*last),
                readable(*planned)
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
