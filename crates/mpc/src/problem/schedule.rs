//! What changes over the run in a known way: parameters of the controller's model, and references.

use crate::ocp::{Ocp, Rows, ScaledRows, coefficient_name};
use std::fmt;
use std::sync::Arc;

/// A function of time.
type OfTime = Arc<dyn Fn(f64) -> f64 + Send + Sync>;

/// A quantity with its value at every time (s) of the run.
#[derive(Clone)]
pub struct Scheduled {
    /// Its name.
    pub name: String,
    value: OfTime,
    varies: bool,
    /// Its first and second derivatives, where the scale of time is to be decided on.
    rates: Option<[OfTime; 2]>,
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
            rates: None,
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
            rates: None,
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

    /// With its first and second derivatives: in a problem whose scale of time σ is an input, it is a polynomial in σ.
    pub(crate) fn with_rates(self, first: Self, second: Self) -> Self {
        Self { rates: self.varies.then_some([first.value, second.value]), ..self }
    }

    /// Its names in a problem: one, and those of the coefficients of σ and σ² where the scale of time σ is an input.
    pub(crate) fn names(&self) -> impl Iterator<Item = String> {
        let orders = if self.rates.is_some() { 0..=2 } else { 0..=0 };
        orders.map(|order| coefficient_name(&self.name, order))
    }

    /// Appends to a row its value at the time σ τ, or the coefficients of its Taylor polynomial of order 2 in σ.
    fn append(&self, tau: f64, scale: f64, row: &mut Vec<f64>) {
        let t = scale * tau;
        let Some(rates) = &self.rates else { return row.push(self.at(t)) };
        // At the start, the scale does not matter, and a rate need not be finite.
        let [slope, curvature] = if tau == 0.0 { [0.0; 2] } else { [tau * rates[0](t), tau * tau * rates[1](t)] };
        row.extend([
            self.at(t) - scale * (slope - scale * curvature / 2.0),
            slope - scale * curvature,
            curvature / 2.0,
        ]);
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

    /// The names of a list in a problem, see [`Scheduled::names`].
    pub(crate) fn names(list: &[Scheduled]) -> Vec<String> {
        list.iter().flat_map(Scheduled::names).collect()
    }

    /// Writes the rows of the grid points `first` … `first + points` into the problem.
    pub fn write(&self, ocp: &mut Ocp, first: usize, points: usize) {
        let rows = self.rows(ocp.dt, first, points, 1.0);
        ocp.first_row = first;
        if !rows.parameters.is_empty() {
            ocp.parameters = rows.parameters;
        }
        if !rows.references.is_empty() {
            ocp.references = rows.references;
        }
    }

    /// Lets the rows of the grid points 0 … `points` follow the input that scales time.
    pub(crate) fn scale_time(&self, ocp: &mut Ocp, input: usize, points: usize) {
        if self.varies() {
            let (schedule, dt) = (self.clone(), ocp.dt);
            ocp.scaled_rows = Some(ScaledRows::new(input, move |scale| schedule.rows(dt, 0, points, scale)));
        }
    }

    /// The rows of the grid points `first` … `first + points`, where time is scaled by `scale`.
    fn rows(&self, dt: f64, first: usize, points: usize, scale: f64) -> Rows {
        let rows = |columns: &[&Scheduled]| -> Vec<Vec<f64>> {
            let row = |k: usize| {
                let mut row = Vec::new();
                for s in columns {
                    s.append(k as f64 * dt, scale, &mut row);
                }
                row
            };
            if columns.is_empty() { Vec::new() } else { (first..=first + points).map(row).collect() }
        };
        Rows {
            parameters: rows(&self.parameters.iter().collect::<Vec<_>>()),
            references: rows(&self.parameters.iter().chain(&self.references).collect::<Vec<_>>()),
        }
    }
}
