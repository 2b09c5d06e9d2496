//! What one sample of a controller gives.

use crate::qp::QpStatus;

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
