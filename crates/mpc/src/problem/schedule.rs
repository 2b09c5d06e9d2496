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
    /// Whether it comes from a table with one row.
    pub(super) one_row: bool,
    /// The quantity whose derivative it is, and the order.
    derivative_of: Option<(String, u32)>,
}

impl Scheduled {
    /// A quantity that follows a function of time.
    pub fn new(name: impl Into<String>, value: impl Fn(f64) -> f64 + Send + Sync + 'static) -> Self {
        Self {
            name: name.into(),
            value: Arc::new(value),
            varies: true,
            last: None,
            one_row: false,
            derivative_of: None,
        }
    }

    /// A quantity that keeps its value.
    pub fn constant(name: impl Into<String>, value: f64) -> Self {
        Self {
            name: name.into(),
            value: Arc::new(move |_| value),
            varies: false,
            last: None,
            one_row: false,
            derivative_of: None,
        }
    }

    /// The quantity, given by `rows` of a table up to the time `last` (s), after which its value is kept.
    pub(crate) fn of_table(self, last: Option<f64>, rows: usize) -> Self {
        Self { last, one_row: rows == 1, ..self }
    }

    /// Says whose derivative it is; an order of 0 is none.
    pub(crate) fn derivative_of(self, name: &str, order: u32) -> Self {
        Self { derivative_of: (order > 0).then(|| (name.to_owned(), order)), ..self }
    }

    /// Whether it is the derivative of another quantity, which it follows.
    pub fn is_derivative(&self) -> bool {
        self.derivative_of.is_some()
    }

    /// The order of the derivative of `name` that it is.
    pub(crate) fn order_of(&self, name: &str) -> Option<u32> {
        self.derivative_of.as_ref().filter(|of| of.0 == name).map(|of| of.1)
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

/// What a problem makes of a reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReferenceUse {
    /// Its name.
    pub name: String,
    /// Whether a cost or constraint uses it.
    pub used: bool,
    /// The state or input that a cost draws to it.
    pub tracked_by: Option<String>,
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
