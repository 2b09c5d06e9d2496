//! What is to be said about a closed-loop run.

use crate::closed_loop::{Counts, SolveTimes};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

/// The plan that was made before the run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlanReport {
    /// How the solution process ended.
    pub status: String,
    /// Number of quadratic programs.
    pub programs: usize,
    /// Largest mismatch between intervals, in units of the state scales.
    pub defect: f64,
    /// Time taken, s.
    pub seconds: f64,
}

/// Values of states by name, in the order of the model; as JSON one object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NamedValues(Vec<(String, f64)>);

impl NamedValues {
    /// The value of a name.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// Names and values, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&str, f64)> {
        self.0.iter().map(|(name, value)| (name.as_str(), *value))
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl FromIterator<(String, f64)> for NamedValues {
    fn from_iter<I: IntoIterator<Item = (String, f64)>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}

impl Serialize for NamedValues {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in self.iter() {
            map.serialize_entry(name, &value)?;
        }
        map.end()
    }
}

/// Figures of a closed-loop run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClosedLoopReport {
    /// Σ dt·stage cost at the sampled states with the applied inputs.
    pub closed_loop_cost: f64,
    /// Stage and terminal cost, as predicted from the initial state, of the first plan that an input is taken from: with
    /// [`Method::Rti`](super::Method::Rti) after its initial programs, else the converged one. NaN where there is no such plan.
    pub open_loop_cost: f64,
    /// State at the end.
    pub x_final: NamedValues,
    /// What is missing to every target at the end.
    #[serde(skip_serializing_if = "NamedValues::is_empty")]
    pub miss: NamedValues,
    /// Number of samples.
    pub steps: usize,
    /// Outcomes of the samples.
    pub status: Counts,
    /// Times per sample.
    pub solve_ms: SolveTimes,
    /// Sampling period, ms.
    pub period_ms: f64,
    /// Largest violation of a bound or named constraint, each in its own unit.
    pub constraint_violation_max: f64,
    /// The plan, where one was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<PlanReport>,
    /// What went wrong: how often, where first, and what to do about it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Whether the run did what was asked: every target met within its tolerance (without targets: the plan, where there is
    /// one, converged), no sample infeasible or fallen back on an old input, and every figure finite.
    pub succeeded: bool,
}
