//! Why something was not found.

use serde::Serialize;

use crate::sum_of_squares::program::Unsolved;

/// Why there is no certificate.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum CertificateReason {
    /// The equations use a derivative of an input.
    InputDerivative {
        /// The input.
        input: String,
    },
    /// An input acts later than it is commanded.
    InputDelay {
        /// The input.
        input: String,
    },
    /// An equation is no polynomial with rational coefficients, or has too many terms.
    NotPolynomial {
        /// The state.
        of: String,
    },
    /// A coordinate of the point is no rational number.
    IrrationalPoint {
        /// State or input.
        name: String,
    },
    /// The point is no equilibrium.
    NotEquilibrium {
        /// A state that moves.
        state: String,
        /// Its derivative at the point.
        derivative: f64,
    },
    /// The linearization has an eigenvalue with positive real part: the equilibrium is unstable, and no Lyapunov function exists.
    Unstable {
        /// Their number.
        eigenvalues: usize,
    },
    /// The linearization has an eigenvalue with real part zero: no quadratic form decides.
    Critical,
    /// Linear equations of the coefficients have no solution: exact, for sums of squares of the degree and monomials tried.
    Excluded {
        /// Largest degree tried.
        degree: u32,
    },
    /// No solution of the semidefinite program up to rounding; there may be one of a higher degree, or none.
    NotFound {
        /// Largest degree tried.
        degree: u32,
    },
    /// A numerical solution did not pass the exact check.
    NotConfirmed,
    /// Too many monomials for the semidefinite program.
    TooLarge,
    /// Out of time or memory, or stopped.
    OutOfTime,
    /// Inputs and outputs differ in number, or there are none.
    NoPorts {
        /// Number of inputs.
        inputs: usize,
        /// Number of outputs.
        outputs: usize,
    },
    /// The equations are not affine in the inputs.
    NotAffine,
    /// An output is no polynomial of the states, or depends on an input.
    OutputForm,
}

impl CertificateReason {
    pub(crate) fn of(unsolved: Unsolved, degree: u32) -> Self {
        match unsolved {
            Unsolved::Contradiction => CertificateReason::Excluded { degree },
            Unsolved::NotFeasible => CertificateReason::NotFound { degree },
            Unsolved::TooLarge => CertificateReason::TooLarge,
            Unsolved::NotRounded => CertificateReason::NotConfirmed,
            Unsolved::OutOfTime => CertificateReason::OutOfTime,
        }
    }
}
