//! What is applied to the plant when a sample has no solution.

use super::step::InputSource;
use crate::error::{MpcError, check_length, check_value};
use crate::trajectory::PlannedTrajectory;

/// One input that brakes one velocity: u = rest − rate · v, within the input's bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brake {
    /// Index of the input, which accelerates the velocity (∂v'/∂u > 0).
    pub input: usize,
    /// Index of the state that is braked.
    pub velocity: usize,
    /// Unit of the input per unit of the velocity. For v' = u, 1/dt stops within a sample where the bounds allow it;
    /// more than 2/dt is unstable.
    pub rate: f64,
}

/// What a controller does at a sample without a solution: measurement lost or not a number, program not solved, time over.
///
/// Every input is brought into its bounds.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum FailurePolicy {
    /// The last usable plan, shifted by one interval per sample; the rest input when it has been used up.
    #[default]
    ShiftedInput,
    /// The plan for a number of samples in a row (no longer than it lasts), then brakes. The velocities are those measured,
    /// where they are finite, and predicted by the model where they are not.
    BrakeToRest {
        /// Samples in a row that follow the plan first.
        after: usize,
        /// The brakes; inputs without one get the rest input.
        brakes: Vec<Brake>,
    },
    /// The input of rest at once.
    RestInput,
}

impl FailurePolicy {
    pub(crate) fn check(&self, states: usize, inputs: usize) -> Result<(), MpcError> {
        let Self::BrakeToRest { brakes, .. } = self else { return Ok(()) };
        for b in brakes {
            if b.velocity >= states {
                return Err(MpcError::NoSuchState { index: b.velocity, states });
            }
            if b.input >= inputs {
                return Err(MpcError::Length { what: "the list of inputs", found: inputs, expected: b.input + 1 });
            }
            check_value(
                b.rate >= 0.0 && b.rate.is_finite(),
                "the rate of a brake",
                b.rate,
                "give a finite number that is not negative",
            )?;
        }
        Ok(())
    }

    /// Writes the input of the policy to `u`. `failures` counts the samples without a solution before this one, `plan` is the
    /// input planned for now, if the plan has not been used up, and `x` the state, as far as known.
    pub(crate) fn decide(
        &self,
        failures: usize,
        plan: Option<&[f64]>,
        x: &[f64],
        rest: &[f64],
        bounds: &[(f64, f64)],
        u: &mut [f64],
    ) -> InputSource {
        let source = match (self, plan) {
            (Self::ShiftedInput, Some(plan)) => {
                u.copy_from_slice(plan);
                InputSource::Plan
            }
            (Self::BrakeToRest { after, .. }, Some(plan)) if failures < *after => {
                u.copy_from_slice(plan);
                InputSource::Plan
            }
            (Self::BrakeToRest { brakes, .. }, _) => {
                u.copy_from_slice(rest);
                for b in brakes {
                    let change = b.rate * x[b.velocity];
                    if change.is_finite() {
                        u[b.input] -= change;
                    }
                }
                InputSource::Brake
            }
            (Self::ShiftedInput | Self::RestInput, _) => {
                u.copy_from_slice(rest);
                InputSource::Rest
            }
        };
        for (v, b) in u.iter_mut().zip(bounds) {
            *v = v.clamp(b.0, b.1);
        }
        source
    }
}

/// The failure policy at work: what is planned, what has failed, what is known of the state.
#[derive(Clone, Debug)]
pub(crate) struct Failures {
    policy: FailurePolicy,
    rest: Vec<f64>,
    /// Samples without a solution since the last one with.
    in_a_row: usize,
    /// Intervals that have been planned and not yet used.
    planned: usize,
    /// The state: measured where it is finite, else predicted.
    pub(crate) x: Vec<f64>,
}

impl Failures {
    pub(crate) fn new(policy: FailurePolicy, rest: Vec<f64>, states: usize, planned: usize) -> Self {
        Self { policy, rest, in_a_row: 0, planned, x: vec![f64::NAN; states] }
    }

    /// Samples without a solution since the last one with.
    pub(crate) fn in_a_row(&self) -> usize {
        self.in_a_row
    }

    /// The input of rest.
    pub(crate) fn rest(&self) -> &[f64] {
        &self.rest
    }

    /// Replaces the rest input.
    pub(crate) fn set_rest(&mut self, rest: Vec<f64>) {
        self.rest = rest;
    }

    /// Takes over what has been measured.
    pub(crate) fn believe(&mut self, measured: &[f64]) {
        for (x, &m) in self.x.iter_mut().zip(measured) {
            if m.is_finite() {
                *x = m;
            }
        }
    }

    /// Notes a solution for `steps` intervals.
    pub(crate) fn solved(&mut self, steps: usize) {
        self.in_a_row = 0;
        self.planned = steps;
    }

    /// Notes a solution ahead of the measurement.
    pub(crate) fn plan_ahead(&mut self, steps: usize) {
        self.planned = steps;
    }

    /// The input planned for now.
    pub(crate) fn plan<'a>(&self, trajectory: &'a PlannedTrajectory) -> Option<&'a [f64]> {
        (self.planned > 0 && trajectory.steps() > 0).then(|| trajectory.u(0))
    }

    /// Writes the policy's input to `u`.
    pub(crate) fn decide(
        &mut self,
        trajectory: &PlannedTrajectory,
        bounds: &[(f64, f64)],
        u: &mut [f64],
    ) -> InputSource {
        let plan = self.plan(trajectory);
        let source = self.policy.decide(self.in_a_row, plan, &self.x, &self.rest, bounds, u);
        self.in_a_row += 1;
        source
    }

    /// Writes the planned input to `u`, or the rest input.
    pub(crate) fn play_out(&self, trajectory: &PlannedTrajectory, bounds: &[(f64, f64)], u: &mut [f64]) -> InputSource {
        let plan = self.plan(trajectory);
        FailurePolicy::ShiftedInput.decide(self.in_a_row, plan, &self.x, &self.rest, bounds, u)
    }

    /// Whether samples have failed until nothing planned was left.
    pub(crate) fn used_up(&self) -> bool {
        self.in_a_row > 0 && self.planned == 0
    }

    /// Moves on by one interval.
    pub(crate) fn shift(&mut self) {
        self.planned = self.planned.saturating_sub(1);
    }
}

/// The input of rest: `given`, or the one closest to zero within the bounds when empty.
pub(crate) fn rest_input(given: &[f64], bounds: &[(f64, f64)]) -> Result<Vec<f64>, MpcError> {
    if given.is_empty() {
        return Ok(bounds.iter().map(|b| 0f64.clamp(b.0, b.1)).collect());
    }
    check_length("the rest input", given.len(), bounds.len())?;
    for (&value, b) in given.iter().zip(bounds) {
        check_value(
            b.0 <= value && value <= b.1 && value.is_finite(),
            "the rest input",
            value,
            "give a finite number within the bounds of the input",
        )?;
    }
    Ok(given.to_vec())
}
