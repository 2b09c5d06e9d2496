//! Settings of the area-contact model.

use crate::PlateError;
use crate::model::{GRAVITY, Terms};
use serde::{Deserialize, Serialize};

/// How a step is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Scheme {
    /// Implicit Euler: first order, every step dissipates.
    Euler,
    /// Two implicit stages of the singly diagonally implicit Runge–Kutta method with `γ = 1 − 1/√2` (Alexander 1977): second
    /// order, damps what is stiff. A step in which friction stops everything is one of implicit Euler.
    SecondOrder,
}

/// Settings of [`crate::area::AreaContact`].
#[derive(Debug, Clone, PartialEq)]
pub struct AreaSettings {
    /// Time step in s.
    pub step: f64,
    /// Number of contact points, about; see [`crate::Shape::quadrature`].
    pub points: usize,
    /// How a step is made.
    pub scheme: Scheme,
    /// Gravity in m/s².
    pub gravity: f64,
    /// Terms of the equations; those of the reduced model only have no part here.
    pub terms: Terms,
}

impl Default for AreaSettings {
    /// 1 ms, 48 points, second order, 9.81 m/s², all terms.
    fn default() -> Self {
        Self { step: 1e-3, points: 48, scheme: Scheme::SecondOrder, gravity: GRAVITY, terms: Terms::default() }
    }
}

impl AreaSettings {
    /// The time step in seconds.
    #[must_use]
    pub fn with_step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// The number of contact points.
    #[must_use]
    pub fn with_points(mut self, points: usize) -> Self {
        self.points = points;
        self
    }

    /// How a step is made.
    #[must_use]
    pub fn with_scheme(mut self, scheme: Scheme) -> Self {
        self.scheme = scheme;
        self
    }

    /// The terms of the equations.
    #[must_use]
    pub fn with_terms(mut self, terms: Terms) -> Self {
        self.terms = terms;
        self
    }

    pub(super) fn validate(&self) -> Result<(), PlateError> {
        for (name, value) in [("step", self.step), ("gravity", self.gravity)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(PlateError::BadNumber { name, value });
            }
        }
        Ok(())
    }
}
