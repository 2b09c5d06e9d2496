//! Methods of integration.

use crate::error::{MpcError, check_value};

/// The method that advances the state over an interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integrator {
    /// The classical explicit Runge–Kutta method of order 4.
    #[default]
    Rk4,
    /// Collocation at the Gauss–Legendre points: implicit, order 2·stages, A-stable, symplectic.
    GaussLegendre {
        /// Number of collocation points, 1 to 4.
        stages: usize,
    },
    /// Collocation at the right Radau points: implicit, order 2·stages − 1, L-stable; for stiff dynamics.
    RadauIIA {
        /// Number of collocation points, 1 to 4 (1 is the implicit Euler method).
        stages: usize,
    },
    /// None: the dynamics are discrete in time and give the next state. An interval applies them once per integration step.
    Map,
}

impl Integrator {
    /// Order of convergence; 0 for a map, which approximates nothing.
    pub fn order(self) -> usize {
        match self {
            Self::Rk4 => 4,
            Self::Map => 0,
            Self::GaussLegendre { stages } => 2 * stages,
            Self::RadauIIA { stages } => 2 * stages - 1,
        }
    }

    /// Whether a step solves equations, so that stiffness does not limit its length.
    pub fn is_implicit(self) -> bool {
        match self {
            Self::Rk4 | Self::Map => false,
            Self::GaussLegendre { .. } | Self::RadauIIA { .. } => true,
        }
    }

    pub(crate) fn check(self) -> Result<(), MpcError> {
        let stages = match self {
            Self::Rk4 | Self::Map => return Ok(()),
            Self::GaussLegendre { stages } | Self::RadauIIA { stages } => stages,
        };
        let what = "the number of stages of the integrator";
        check_value((1..=4).contains(&stages), what, stages as f64, "give 1, 2, 3, or 4")
    }
}
