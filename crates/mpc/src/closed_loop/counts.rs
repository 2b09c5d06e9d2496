//! What happened in a run, counted, and the times that its samples took.

use crate::controller::{FallbackReason, InputSource, Step, StepStatus, Timings};
use crate::qp::QpStatus;
use serde::{Serialize, Serializer};

/// How often each status occurred.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Inputs from programs solved to full accuracy.
    pub solved: usize,
    /// Inputs from less accurate solutions.
    pub inaccurate: usize,
    /// Inputs from programs in which a hard bound cannot be kept.
    pub infeasible: usize,
    /// Inputs of the failure policy.
    pub fallback: usize,
    /// Samples after the end of a plan, for which nothing is solved.
    pub played_out: usize,
    /// Why the failure policy decided, once for each of `fallback`.
    pub reasons: ReasonCounts,
    /// Where the inputs of all samples come from.
    pub sources: SourceCounts,
}

/// How often the failure policy decided for each [`FallbackReason`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReasonCounts {
    /// Nothing was measured.
    pub lost_sample: usize,
    /// The measurement was not finite.
    pub measurement: usize,
    /// The linearization was not finite.
    pub linearization: usize,
    /// The cost along the plan was not finite.
    pub cost: usize,
    /// The time of the sample was over.
    pub time_limit: usize,
    /// The program reached its iteration limit.
    pub qp_limit: usize,
    /// The program failed numerically.
    pub qp_failed: usize,
}

/// How often an input came from each [`InputSource`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SourceCounts {
    /// Programs solved for the measurement.
    pub program: usize,
    /// Programs solved ahead and moved to the measurement by the tangential predictor.
    pub tangent: usize,
    /// The last usable plan, shifted.
    pub plan: usize,
    /// The law that brakes.
    pub brake: usize,
    /// The input of rest.
    pub rest: usize,
}

impl Counts {
    /// Counts one sample.
    pub fn add(&mut self, step: &Step) {
        let counter = match step.status {
            StepStatus::Solved => &mut self.solved,
            StepStatus::PlayedOut => &mut self.played_out,
            StepStatus::Inaccurate => &mut self.inaccurate,
            StepStatus::Infeasible => &mut self.infeasible,
            StepStatus::Fallback(reason) => {
                self.reasons.add(reason);
                &mut self.fallback
            }
        };
        *counter += 1;
        *match step.source {
            InputSource::Program => &mut self.sources.program,
            InputSource::Tangent => &mut self.sources.tangent,
            InputSource::Plan => &mut self.sources.plan,
            InputSource::Brake => &mut self.sources.brake,
            InputSource::Rest => &mut self.sources.rest,
        } += 1;
    }

    /// Number of samples counted.
    pub fn samples(&self) -> usize {
        self.solved + self.inaccurate + self.infeasible + self.fallback + self.played_out
    }
}

impl Serialize for ReasonCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let counts = [
            ("lost_sample", self.lost_sample),
            ("measurement", self.measurement),
            ("linearization", self.linearization),
            // The name of this key in earlier versions, for programs that read it.
            ("linearisation", self.linearization),
            ("cost", self.cost),
            ("time_limit", self.time_limit),
            ("qp_limit", self.qp_limit),
            ("qp_failed", self.qp_failed),
        ];
        serializer.collect_map(counts)
    }
}

impl ReasonCounts {
    fn add(&mut self, reason: FallbackReason) {
        *match reason {
            FallbackReason::LostSample => &mut self.lost_sample,
            FallbackReason::Measurement => &mut self.measurement,
            FallbackReason::Linearization | FallbackReason::Qp(QpStatus::NotANumber) => &mut self.linearization,
            FallbackReason::Cost => &mut self.cost,
            FallbackReason::TimeLimit => &mut self.time_limit,
            FallbackReason::Qp(QpStatus::Limit) => &mut self.qp_limit,
            FallbackReason::Qp(_) => &mut self.qp_failed,
        } += 1;
    }

    /// Their sum.
    pub fn total(&self) -> usize {
        self.lost_sample
            + self.measurement
            + self.linearization
            + self.cost
            + self.time_limit
            + self.qp_limit
            + self.qp_failed
    }
}

impl SourceCounts {
    /// Their sum.
    pub fn total(&self) -> usize {
        self.program + self.tangent + self.plan + self.brake + self.rest
    }
}

/// Times of the samples, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SolveTimes {
    /// Half of the samples take less.
    pub median: f64,
    /// 99 % of the samples take less.
    pub p99: f64,
    /// Longest.
    pub max: f64,
}

impl SolveTimes {
    /// Order statistics of times in seconds; zeros for none.
    pub fn of(seconds: &[f64]) -> Self {
        let mut sorted = seconds.to_vec();
        sorted.sort_by(f64::total_cmp);
        let at = |q: f64| {
            let i = (q * sorted.len() as f64).ceil() as usize;
            1e3 * sorted.get(i.saturating_sub(1).min(sorted.len().saturating_sub(1))).copied().unwrap_or(0.0)
        };
        Self { median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}

/// Samples whose input took longer to find, preparation included, than the sampling period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LateSamples {
    /// Their number.
    pub samples: usize,
    /// Their share of all samples.
    pub share: f64,
    /// Longest time of one of them, ms; 0 where there are none.
    pub longest_ms: f64,
    /// Number of all samples.
    #[serde(skip)]
    of: usize,
}

impl LateSamples {
    /// Counts a sample that took so many seconds.
    pub fn add(&mut self, seconds: f64, period: f64) {
        self.of += 1;
        if seconds > period {
            self.samples += 1;
            self.longest_ms = self.longest_ms.max(1e3 * seconds);
        }
        self.share = self.samples as f64 / self.of as f64;
    }
}

/// Times of the phases of the samples, ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseTimes {
    /// Preparation, before the measurement.
    pub prepare: SolveTimes,
    /// Quadratic programs of the feedback.
    pub qp: SolveTimes,
    /// Everything else of the feedback.
    pub rest: SolveTimes,
    /// The whole feedback: from the measurement to the input.
    pub feedback: SolveTimes,
}

impl PhaseTimes {
    /// Order statistics of the samples' timings.
    pub fn of(timings: &[Timings]) -> Self {
        let phase = |f: fn(&Timings) -> f64| SolveTimes::of(&timings.iter().map(f).collect::<Vec<f64>>());
        Self {
            prepare: phase(|t| t.linearize),
            qp: phase(|t| t.qp),
            rest: phase(|t| t.rest),
            feedback: phase(Timings::feedback),
        }
    }
}
