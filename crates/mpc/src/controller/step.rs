//! What one sample of a controller gives.

use crate::qp::QpStatus;
use serde::Serialize;
use std::iter::Sum;
use std::ops::AddAssign;

/// Why the failure policy decided on the input in place of a new solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FallbackReason {
    /// Nothing was measured: every entry of the measurement is NaN.
    LostSample,
    /// The measurement has an entry that is not finite.
    Measurement,
    /// The linearization has an entry that is not finite.
    Linearization,
    /// The cost along the plan is not finite.
    Cost,
    /// The time of the sample was over before there was a solution.
    TimeLimit,
    /// The quadratic program was not solved.
    Qp(QpStatus),
}

impl FallbackReason {
    /// The name in results: `lost_sample`, `measurement`, `linearization`, `cost`, `time_limit`, `qp_limit`, `qp_failed`.
    pub fn name(self) -> &'static str {
        match self {
            Self::LostSample => "lost_sample",
            Self::Measurement => "measurement",
            Self::Linearization | Self::Qp(QpStatus::NotANumber) => "linearization",
            Self::Cost => "cost",
            Self::TimeLimit => "time_limit",
            Self::Qp(QpStatus::Limit) => "qp_limit",
            Self::Qp(_) => "qp_failed",
        }
    }

    /// Why nothing can be solved from this measurement; `None` where it is finite.
    pub(crate) fn of_measurement(x: &[f64]) -> Option<Self> {
        if x.iter().all(|v| v.is_finite()) {
            None
        } else if x.iter().all(|v| v.is_nan()) {
            Some(Self::LostSample)
        } else {
            Some(Self::Measurement)
        }
    }
}

/// Outcome of one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepStatus {
    /// A new input from a program solved to full accuracy.
    Solved,
    /// A new input from a program solved to reduced accuracy.
    Inaccurate,
    /// A new input, but a hard bound cannot be kept: the violation is as small as it can be.
    Infeasible,
    /// The shrinking horizon is (nearly) used up: the plan is played out.
    PlayedOut,
    /// The input of the failure policy; [`Step::source`] says which.
    Fallback(FallbackReason),
}

impl StepStatus {
    /// The name in results: `solved`, `inaccurate`, `infeasible`, `played_out`, `fallback`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Inaccurate => "inaccurate",
            Self::Infeasible => "infeasible",
            Self::PlayedOut => "played_out",
            Self::Fallback(_) => "fallback",
        }
    }

    /// Why the failure policy decided; none where it did not.
    pub fn fallback_reason(self) -> Option<FallbackReason> {
        if let Self::Fallback(reason) = self { Some(reason) } else { None }
    }
}

/// Where an input comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputSource {
    /// A program solved for this measurement.
    Program,
    /// A program solved ahead, moved to this measurement by the tangential predictor.
    Tangent,
    /// The last usable plan, shifted.
    Plan,
    /// The law that brakes.
    Brake,
    /// The input of rest.
    Rest,
}

impl InputSource {
    /// The name in results: `program`, `tangent`, `plan`, `brake`, `rest`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Program => "program",
            Self::Tangent => "tangent",
            Self::Plan => "plan",
            Self::Brake => "brake",
            Self::Rest => "rest",
        }
    }
}

/// Where the time of one sample went, s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Preparation: linearization and filling of the program, before the measurement.
    pub linearize: f64,
    /// Quadratic programs of the feedback.
    pub qp: f64,
    /// Everything else of the feedback.
    pub rest: f64,
}

impl Timings {
    /// The whole sample.
    pub fn total(&self) -> f64 {
        self.linearize + self.qp + self.rest
    }

    /// From the measurement to the input.
    pub fn feedback(&self) -> f64 {
        self.qp + self.rest
    }
}

/// What has been solved, in counts that hardly depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SolverEffort {
    /// Quadratic programs.
    pub programs: usize,
    /// Steps of interior-point methods, in the programs and on the nonlinear equations.
    pub interior_point_steps: usize,
}

impl AddAssign for SolverEffort {
    fn add_assign(&mut self, more: Self) {
        self.programs += more.programs;
        self.interior_point_steps += more.interior_point_steps;
    }
}

impl Sum for SolverEffort {
    fn sum<I: Iterator<Item = Self>>(efforts: I) -> Self {
        efforts.fold(Self::default(), |mut sum, effort| {
            sum += effort;
            sum
        })
    }
}

/// One sample's input.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Input to apply over the next interval.
    pub u: Vec<f64>,
    /// Outcome of the sample.
    pub status: StepStatus,
    /// Where the input comes from.
    pub source: InputSource,
    /// Times taken.
    pub timings: Timings,
    /// What was solved for it, preparation included.
    pub effort: SolverEffort,
    /// Residual of the conditions of optimality (Karush, Kuhn, and Tucker), without units: the largest of the slope of the Lagrangian and the
    /// defects of the dynamics, with the multipliers of the last program and before its step. With one program per sample, this is the
    /// shifted plan at the measured state, so a plant that differs from the model shows. With converged solutions, the step is
    /// negligible, and the residual is about the square root of the tolerance or less. None where nothing was solved, and with
    /// exact friction.
    pub residual: Option<f64>,
}

impl Step {
    /// Takes over another step of as many inputs, without allocating.
    pub(crate) fn copy_from(&mut self, other: &Self) {
        self.u.clone_from(&other.u);
        (self.status, self.source) = (other.status, other.source);
        (self.timings, self.effort, self.residual) = (other.timings, other.effort, other.residual);
    }

    /// What stands before the first sample: nothing has been decided.
    pub(crate) fn undecided(inputs: usize) -> Self {
        Self {
            u: vec![0.0; inputs],
            status: StepStatus::PlayedOut,
            source: InputSource::Rest,
            timings: Timings::default(),
            effort: SolverEffort::default(),
            residual: None,
        }
    }
}

/// Limits of a single sample on top of those of the controller's settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLimits {
    /// Largest number of iterations of the solver.
    pub iterations: u32,
    /// Largest time, s.
    pub time: f64,
}

impl Default for StepLimits {
    /// No limits.
    fn default() -> Self {
        Self { iterations: u32::MAX, time: f64::INFINITY }
    }
}
