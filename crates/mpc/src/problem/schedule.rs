//! What changes over the run in a known way: parameters of the controller's model, and references.

use crate::ocp::Ocp;
use std::fmt;
use std::sync::Arc;

/// A quantity with its value at every time (s) of the run.
#[derive(Clone)]
pub struct Scheduled {
    /// Its name.
    pub name: String,
    value: Arc<dyn Fn(f64) -> f64 + Send + Sync>,
    varies: bool,
    pub(super) last: Option<f64>,
}

impl Scheduled {
    /// A quantity that follows a function of time.
    pub fn new(name: impl Into<String>, value: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        Self { name: name.into(), value: Arc::new(value), varies: true, last: None }
    }

    /// A quantity that keeps its value.
    pub fn constant(name: impl Into<String>, value: f64) -> Self {
        Self { name: name.into(), value: Arc::new(move |_| value), varies: false, last: None }
    }

    /// The quantity, given up to the time `last` (s), after which its value is kept; none if it is given at all times.
    pub(crate) fn until(self, last: Option<f64>) -> Self {
        Self { last, ..self }
    }

    /// Its value at a time.
    pub fn at(&self, t: f64) -> f64 {
        (self.value)(t)
    }
}

impl fmt::Debug for Scheduled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Scheduled").field("name", &self.name).field("varies", &self.varies).finish_non_exhaustive()
    }
}

/// Everything that is scheduled: first parameters of the model, which costs and constraints see too, then references.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    /// Parameters of the controller's model.
    pub parameters: Vec<Scheduled>,
    /// References of costs and constraints.
    pub references: Vec<Scheduled>,
}

impl Schedule {
    /// Whether a horizon further on needs other rows.
    pub(crate) fn varies(&self) -> bool {
        self.parameters.iter().chain(&self.references).any(|s| s.varies)
    }

    /// Writes the rows of the grid points `first` … `first + points` into the problem.
    pub fn write(&self, ocp: &mut Ocp, first: usize, points: usize) {
        let dt = ocp.dt;
        let rows = |columns: &[&Scheduled]| -> Vec<Vec<f64>> {
            let row = |k: usize| columns.iter().map(|s| s.at(k as f64 * dt)).collect();
            (first..=first + points).map(row).collect()
        };
        ocp.first_row = first;
        if !self.parameters.is_empty() {
            ocp.parameters = rows(&self.parameters.iter().collect::<Vec<_>>());
        }
        if !self.parameters.is_empty() || !self.references.is_empty() {
            ocp.references = rows(&self.parameters.iter().chain(&self.references).collect::<Vec<_>>());
        }
    }
}
