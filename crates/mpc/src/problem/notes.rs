//! What went wrong in a run, and what to do about it.

use super::cause::Cause;
use crate::closed_loop::Refined;
use crate::controller::FallbackReason;
use bracketry_system::Eliminated;
use serde::{Serialize, Serializer};

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
    /// The fixed steps of the plant were not accurate: it was simulated with error control.
    PlantRefined(Refined),
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
    /// The search for free values did not converge.
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
    /// The method was chosen without a converged plan, and nothing shows that the loop does as well as one.
    ChosenWithoutPlan,
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
            | Self::SearchNotConverged { .. }
            | Self::ChosenWithoutPlan
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
            | Self::BeyondRange { .. }
            | Self::PlantRefined(_)
            | Self::RoundingCosts { .. }
            | Self::Unobservable { .. }
            | Self::Singular { .. }
            | Self::EstimateOff { .. }
            | Self::Inaccurate { .. } => false,
        }
    }
}

impl Serialize for Note {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
