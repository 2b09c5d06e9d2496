//! The scenario tree of a problem whose parameters are uncertain.

use super::control_problem::{ControlProblem, ScenarioTree};
use super::method::Method;
use super::start::Prepared;
use crate::controller::{Branches, shown_branch};
use crate::error::MpcError;
use crate::sqp::Solution;
use bracketry_symbolic::Named;
use serde::Serialize;

/// The scenario tree of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ScenarioReport {
    /// Number of branches, each one with a copy of the model.
    pub branches: usize,
    /// Intervals at whose start the branches part.
    pub robust_horizon: usize,
    /// The values that the uncertain parameters are taken to have, together.
    pub scenarios: Vec<Named<f64>>,
    /// Largest violation of a bound or constraint that a plan of the run predicts in any branch, each in its own unit; none where
    /// there is no plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub predicted_violation: Option<f64>,
}

impl ScenarioTree {
    /// The problem of all branches, with what has been changed in that of one branch since the file was read.
    fn of(&self, own: &ControlProblem) -> ControlProblem {
        let count = self.branches();
        let mut problem = self.problem.clone();
        problem.ocp.take_over_changes(&self.own, &own.ocp);
        problem.x0 = own.x0.repeat(count);
        problem.schedule.clone_from(&own.schedule);
        problem.samples = own.samples;
        problem.stop = own.stop.clone();
        problem
    }

    fn branches(&self) -> usize {
        self.problem.ocp.branching.as_ref().map_or(1, |b| b.branches)
    }

    /// The problem of one branch with its method, and the controller of all branches at its start.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together.
    pub(super) fn started(&self, own: &ControlProblem) -> Result<(ControlProblem, Prepared), MpcError> {
        let all = self.of(own);
        let (chosen, prepared) = match all.method {
            Method::Automatic { convergence } => all.choose_method(convergence)?,
            _ => (all.clone(), all.prepared()?),
        };
        let ControlProblem { method, method_reason, smoothing, .. } = chosen;
        let problem = ControlProblem { method, method_reason, smoothing, ..own.clone() };
        let Prepared { controller, plan, predicted } = prepared;
        let plan = plan.map(|plan| self.shown(own, plan));
        let controller = Box::new(Branches::new(controller, own.ocp.clone(), self.nominal));
        Ok((problem, Prepared { controller, plan, predicted }))
    }

    /// The plan of all branches, as that of the branch that is shown; its cost is the mean.
    ///
    /// # Errors
    /// If the pieces of the problem do not fit together.
    pub(super) fn plan(&self, own: &ControlProblem) -> Result<Solution, MpcError> {
        Ok(self.shown(own, self.of(own).plan()?))
    }

    fn shown(&self, own: &ControlProblem, plan: Solution) -> Solution {
        let trajectory = shown_branch(&plan.trajectory, &own.ocp, self.branches(), self.nominal);
        let end = trajectory.x(trajectory.steps());
        let miss = own.ocp.targets.iter().map(|t| end[t.state] - t.value).collect();
        Solution { trajectory, miss, ..plan }
    }

    /// What is to be said of it.
    pub(super) fn report(&self, predicted_violation: Option<f64>) -> ScenarioReport {
        ScenarioReport {
            branches: self.branches(),
            robust_horizon: self.robust_horizon,
            scenarios: self.combinations.clone(),
            predicted_violation,
        }
    }
}
