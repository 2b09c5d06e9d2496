//! The end time and the parameters that a plan decides on.

use super::control_problem::ControlProblem;
use super::found_values::FoundValues;
use crate::error::MpcError;
use crate::sqp::SolveStatus;
use bracketry_symbolic::Named;
use std::borrow::Cow;

/// Tolerance of the programs of the search. Where a cost has no curvature, as that of time alone, an end is found as well as the
/// programs are solved: errors of 1e-8 keep the iteration from its end.
const QP_TOLERANCE: f64 = 1e-10;

impl ControlProblem {
    /// Whether an end time or parameters are free, for which no values have been found yet.
    pub fn has_free_values(&self) -> bool {
        self.free.is_some()
    }

    /// The problem with the end time and parameters that its plan decides on, and this plan as its guess; the problem itself where
    /// nothing is free. Whatever runs or steps a problem does this first; do it yourself to see `dt` and the parameters of the
    /// plant.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together, for the values found either. How the solution ended is in
    /// [`ControlProblem::found`].
    pub fn with_free_values(&self) -> Result<Cow<'_, Self>, MpcError> {
        let Some(free) = &self.free else { return Ok(Cow::Borrowed(self)) };
        let mut extended = free.extended.clone();
        extended.x0.clone_from(&self.x0);
        extended.stop = self.stop.clone();
        extended.qp.tolerance = extended.qp.tolerance.min(QP_TOLERANCE);
        let solution = extended.plan()?;
        let inputs = self.ocp.inputs();
        let values = &solution.trajectory.u(0)[inputs..];
        let scale = values.last().copied().unwrap_or(1.0);
        let found = FoundValues {
            end_time: free.end_time.map(|guess| guess * scale),
            parameters: Named(free.parameters.iter().cloned().zip(values.iter().copied()).collect()),
            status: solution.status.to_string(),
            converged: solution.status == SolveStatus::Converged,
            interior_point_steps: solution.interior_point_steps,
            programs: solution.iterations.len(),
            cost: solution.cost,
            seconds: solution.seconds,
        };
        let mut problem = (free.with_found)(&found).map_err(|e| MpcError::ValuesFound { reason: e.to_string() })?;
        for (k, row) in problem.guess.iter_mut().enumerate() {
            row.copy_from_slice(&solution.trajectory.u(k)[..inputs]);
        }
        problem.x0.clone_from(&self.x0);
        problem.samples = self.samples;
        problem.conditions = self.conditions.clone();
        problem.stop = self.stop.clone();
        Ok(Cow::Owned(problem))
    }
}
